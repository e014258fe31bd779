// The checks of a rig, what it was used for, and its relays.
#include <boost/json.hpp>

#include "core/bench/bench.h"
#include "server/api/operate/handlers.h"
#include "server/lab/rig_use.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr int kDays = 30;
constexpr auto kDay = std::chrono::hours(24);
/// `until` may be the next midnight anywhere.
constexpr auto kAhead = std::chrono::hours(48);

json::object StepToJson(const lab::CheckStep& step) {
  json::object out{{"step", step.step},
                   {"subject", step.subject},
                   {"passed", step.passed},
                   {"measured", nullptr},
                   {"low", nullptr},
                   {"high", nullptr},
                   {"unit", ""},
                   {"text", step.text}};
  if (step.figure) {
    out["measured"] = step.figure->measured;
    out["low"] = step.figure->low;
    out["high"] = step.figure->high;
    out["unit"] = step.figure->unit;
  }
  return out;
}

json::array ChecksToJson(const std::vector<lab::CheckRecord>& checks) {
  return ListOf(checks, [](const lab::CheckRecord& check) {
    return json::object{{"id", check.id},
                        {"at", Iso8601(check.at)},
                        {"kind", check.kind},
                        {"passed", check.passed},
                        {"reason", check.reason},
                        {"steps", ListOf(check.steps, StepToJson)}};
  });
}

json::array DaysToJson(const std::vector<lab::rig_use::Hours>& days, WallTime until) {
  const auto seconds = [](lab::Milliseconds part) { return part.count() / 1000; };
  json::array items;
  WallTime start = until - kDay * static_cast<int>(days.size());
  for (const lab::rig_use::Hours& day : days) {
    items.push_back(json::object{{"start", Iso8601(start)},
                                 {"people_s", seconds(day.people)},
                                 {"jobs_s", seconds(day.jobs)},
                                 {"checks_s", seconds(day.checks)},
                                 {"idle_s", seconds(day.idle)},
                                 {"out_s", seconds(day.out)}});
    start += kDay;
  }
  return items;
}

struct Relay {
  std::string component;
  double value = 0.0;
};

/// The relays of a rig by line; empty for a simulator, which has none.
std::map<int, Relay> RelaysOf(const hardware::RigDescription& about) {
  std::map<int, Relay> relays;
  if (about.any_value || about.bench == nullptr) return relays;
  for (const core::Component component : about.bench->components()) {
    if (!core::IsSwitched(component)) continue;
    for (const core::SwitchPosition& position : component.info().positions) {
      relays[position.line] = {std::string(core::Name(component)), position.value};
    }
  }
  return relays;
}

json::array RelaysToJson(const hardware::RigDescription& about,
                         const std::map<int, lab::RelayWear::Count>& counts) {
  json::array items;
  for (const auto& [line, relay] : RelaysOf(about)) {
    const auto found = counts.find(line);
    const bool counted = found != counts.end();
    const double life = about.bench->limits.relay_life;
    const std::int64_t cycles = counted ? found->second.cycles : 0;
    items.push_back(
        json::object{{"line", line},
                     {"component", relay.component},
                     {"value", relay.value},
                     {"cycles", cycles},
                     {"since", counted ? json::value(Iso8601(found->second.since)) : nullptr},
                     {"rated_cycles", life},
                     {"worn", static_cast<double>(cycles) >= lab::RelayWear::kWarnShare * life}});
  }
  return items;
}

core::Status IsRig(Api& api, const std::string& id) {
  if (api.service.state()->rigs.contains(id)) return core::Done{};
  return core::Refuse("nothing_here");
}

core::Result<HttpResponse> GetRigHistory(Api& api, const ApiRequest& request) {
  const std::string& id = request.http.PathParameter("id");
  TRY_DONE(IsRig(api, id));
  const WallTime now = api.clock.Wall();
  TRY(const auto asked, QueryTime(request.http, "until"));
  const WallTime until = asked.value_or(now);
  if (until > now + kAhead || until < now - kDay * kDays) {
    return core::Error{core::ErrorCode::kInvalid,
                       "'until' lies in the last 30 days or the next two.",
                       "until",
                       "invalid"};
  }
  TRY(const auto checks, api.checks.List(id));
  TRY(const auto days, lab::rig_use::HoursOf(api.database, id, until, kDays, now));
  TRY(const auto counts, api.wear.Get(id));
  const auto rig = api.rig_pool.Find(id);  // one of another server may be unknown here
  return JsonResponse(json::object{
      {"checks", ChecksToJson(checks)},
      {"days", DaysToJson(days, until)},
      {"relays", rig.ok() ? RelaysToJson(rig.value().description, counts) : json::array{}}});
}

core::Result<HttpResponse> NoteReplacedRelay(Api& api, const ApiRequest& request) {
  const std::string& id = request.http.PathParameter("id");
  TRY(const auto line, PathNumber(request, "line"));
  TRY(const auto rig, api.rig_pool.Find(id));
  const auto relays = RelaysOf(rig.description);
  if (line > 31 || !relays.contains(static_cast<int>(line))) {
    return core::Refuse("no_relay");
  }
  TRY_DONE(api.wear.Replaced(id, static_cast<int>(line), api.clock.Wall()));
  api.audit.Add(request.who, "replace_relay", "rig:" + id, "Do" + std::to_string(line));
  return NoContent();
}

}  // namespace

std::span<const ApiRoute> HistoryRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "rigs/{id}/history", kOperateRig, kRole, GetRigHistory}.Takes("until"),
      {kPost, "rigs/{id}/relays/{line}/replaced", kOperateRig, kRole, NoteReplacedRelay, kEmpty},
  });
  return kRoutes;
}

}  // namespace faultlab::server
