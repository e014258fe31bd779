#include <boost/json.hpp>

#include "server/api/operate/handlers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::object AlarmToJson(Api& api, const lab::Alarm& alarm) {
  return {{"id", alarm.id},
          {"kind", Name(alarm.kind)},
          {"subject", alarm.subject},
          {"text", alarm.text},
          {"at", Iso8601(alarm.at)},
          {"last", Iso8601(alarm.last)},
          {"times", alarm.times},
          {"ended", TimeOrNull(alarm.ended)},
          {"acknowledged", TimeOrNull(alarm.acked)},
          {"acknowledged_by", PersonToJson(api, alarm.acked_by)}};
}

core::Result<HttpResponse> ListAlarms(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  TRY(const auto state, QueryWord(request.http, "state", {"open", "all"}));
  TRY(const auto alarms, api.alarms.List(state == "all", page.after, page.limit));
  const auto to_json = [&](const lab::Alarm& alarm) { return AlarmToJson(api, alarm); };
  return page.Answer(alarms, to_json, &lab::Alarm::id);
}

core::Result<HttpResponse> AcknowledgeAlarm(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto done, api.alarms.Acknowledge(id, request.who.user_id, api.clock.Wall()));
  const lab::Alarm& alarm = done.alarm;
  if (done.first) {
    api.audit.Add(request.who,
                  "acknowledge",
                  std::string("alarm:") + alarm.subject,
                  std::string(Name(alarm.kind)));
  }
  return JsonResponse(AlarmToJson(api, alarm));
}

}  // namespace

json::value PersonToJson(Api& api, std::int64_t account) {
  if (account == 0) return nullptr;
  const auto found = api.accounts.Get(account);
  if (!found.ok()) return nullptr;
  return json::object{{"login", found.value().login}, {"name", found.value().name}};
}

std::span<const ApiRoute> AlarmsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "alarms", kOperateRig, kRole, ListAlarms}.Takes("cursor limit state"),
      {kPost, "alarms/{id}/acknowledge", kOperateRig, kRole, AcknowledgeAlarm, kEmpty},
  });
  return kRoutes;
}

}  // namespace faultlab::server
