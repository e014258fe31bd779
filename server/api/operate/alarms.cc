#include <boost/json.hpp>

#include "server/api/operate/handlers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::object AlarmToJson(OperateApi& api, const lab::Alarm& alarm) {
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

}  // namespace

core::Result<HttpResponse> ListAlarms(OperateApi& api, const ApiRequest& request) {
  const auto page = PageOf(request.http, {"state"});
  if (!page) return page.error();
  const auto state = QueryWord(request.http, "state", {"open", "all"});
  if (!state) return state.error();
  const auto alarms =
      api.alarms.List(state.value() == "all", page.value().after, page.value().limit);
  if (!alarms) return alarms.error();
  json::array items;
  for (const lab::Alarm& alarm : alarms.value()) items.push_back(AlarmToJson(api, alarm));
  return page.value().Answer(std::move(items),
                             alarms.value().empty() ? 0 : alarms.value().back().id);
}

core::Result<HttpResponse> AcknowledgeAlarm(OperateApi& api, const ApiRequest& request) {
  const auto id = PathNumber(request);
  if (!id) return id.error();
  const auto done = api.alarms.Acknowledge(id.value(), request.who.user_id, api.clock.Wall());
  if (!done) return done.error();
  const lab::Alarm& alarm = done.value().alarm;
  if (done.value().first) {
    api.audit.Add(request.who,
                  "acknowledge",
                  std::string("alarm:") + alarm.subject,
                  std::string(Name(alarm.kind)));
  }
  return JsonResponse(AlarmToJson(api, alarm));
}

}  // namespace faultlab::server
