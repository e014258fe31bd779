// policy: the numbers of the lab's rules that an admin may change.
#include "server/lab/policy_settings.h"

#include <boost/json.hpp>

#include "server/api/api.h"
#include "server/json/json_reader.h"
#include "server/lab/timeline.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::PolicySetting;
using lab::PolicySettings;

HttpResponse PolicyResponse(const PolicySettings& settings) {
  json::object out{{"version", settings.version}};
  for (const PolicySetting& each : lab::kPolicySettings) {
    out[each.name] = ValueOf(settings, each);
  }
  return Versioned(JsonResponse(out), settings.version);
}

core::Result<HttpResponse> GetPolicy(Api& api, const ApiRequest&) {
  return PolicyResponse(api.service.policy());
}

/// What holds for a class; version 0 where it has the lab's settings.
core::Result<HttpResponse> GetClassPolicy(Api& api, const ApiRequest& request) {
  const std::string& rig_class = request.http.PathParameter("rig_class");
  const auto state = api.service.state();
  if (!lab::HasClass(*state, rig_class)) return core::Refuse("no_rig_class");
  const auto own = state->settings.find(rig_class);
  if (own != state->settings.end()) return PolicyResponse(own->second);
  const lab::Policy policy = api.service.policy();
  auto labs = static_cast<const PolicySettings&>(policy);
  labs.version = 0;
  return PolicyResponse(labs);
}

/// Of the lab, or of a class.
core::Result<HttpResponse> Change(Api& api,
                                  const ApiRequest& request,
                                  const std::string& rig_class) {
  TRY(const auto version, RequiredVersion(request));
  PolicySettings wanted;
  wanted.version = version;
  ObjectReader in(request.body, "");
  for (const PolicySetting& each : lab::kPolicySettings) {
    SetValue(wanted, each, in.Integer(each.name, each.least, each.most));
  }
  if (auto error = in.Finish()) return *error;
  PolicySettings before;
  TRY(const auto changed,
      api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Result<PolicySettings> {
        before = scheduler.SettingsOf(rig_class);
        return scheduler.ChangePolicy(wanted, now, rig_class);
      }));
  const std::string object = rig_class.empty() ? "policy" : "rig_class:" + rig_class;
  api.audit.Add(request.who, "change_policy", object, ChangedSettings(before, changed));
  return PolicyResponse(changed);
}

core::Result<HttpResponse> ChangePolicy(Api& api, const ApiRequest& request) {
  return Change(api, request, "");
}

core::Result<HttpResponse> ChangeClassPolicy(Api& api, const ApiRequest& request) {
  return Change(api, request, request.http.PathParameter("rig_class"));
}

core::Result<HttpResponse> DropClassPolicy(Api& api, const ApiRequest& request) {
  const std::string& rig_class = request.http.PathParameter("rig_class");
  TRY_DONE(api.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.DropPolicy(rig_class, now);
  }));
  api.audit.Add(request.who, "change_policy", "rig_class:" + rig_class, "as the lab's");
  return NoContent();
}

}  // namespace

std::span<const ApiRoute> PolicyRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "policy", kListRigs, kRole, GetPolicy},
      {kPut, "policy", kManagePolicy, kRole, ChangePolicy, kJson},
      {kGet, "rig-classes/{rig_class}/policy", kListRigs, kRole, GetClassPolicy},
      {kPut, "rig-classes/{rig_class}/policy", kManagePolicy, kRole, ChangeClassPolicy, kJson},
      {kDelete, "rig-classes/{rig_class}/policy", kManagePolicy, kRole, DropClassPolicy},
  });
  return kRoutes;
}

}  // namespace faultlab::server
