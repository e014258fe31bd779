// policy: the numbers of the lab's rules that an admin may change.
#include "server/lab/policy_settings.h"

#include <boost/json.hpp>

#include "server/api/api.h"
#include "server/json/json_reader.h"

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

core::Result<HttpResponse> ChangePolicy(Api& api, const ApiRequest& request) {
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
        before = static_cast<const PolicySettings&>(scheduler.policy());
        return scheduler.ChangePolicy(wanted, now);
      }));
  api.audit.Add(request.who, "change_policy", "policy", ChangedSettings(before, changed));
  return PolicyResponse(changed);
}

}  // namespace

std::span<const ApiRoute> PolicyRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "policy", kListRigs, kRole, GetPolicy},
      {kPut, "policy", kManagePolicy, kRole, ChangePolicy, kJson},
  });
  return kRoutes;
}

}  // namespace faultlab::server
