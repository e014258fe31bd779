// rig-classes, availability, and what operators do with rigs.
#include <algorithm>
#include <boost/json.hpp>
#include <map>

#include "server/api/api.h"
#include "server/api/rig_json.h"
#include "server/json/json_reader.h"
#include "server/json/number_or_null.h"
#include "server/lab/opening.h"
#include "server/lab/timeline.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::Interval;

constexpr auto kRangeMax = std::chrono::hours(24 * 62);
/// Time to read an offered start and to press a button, before it lies in the past.
constexpr auto kTimeToBook = std::chrono::minutes(1);

/// A whole five minutes of the clock.
WallTime FirstStartToOffer(WallTime now) {
  using FiveMinutes = std::chrono::duration<std::int64_t, std::ratio<300>>;
  return std::chrono::ceil<FiveMinutes>(now + kTimeToBook);
}

json::object IntervalToJson(const Interval& during, std::string_view kind) {
  return {{"start", Iso8601(during.start)}, {"end", Iso8601(during.end)}, {"kind", kind}};
}

json::object RigToJson(const lab::Rig& rig) {
  return {{"id", rig.id},
          {"rig_class", rig.rig_class},
          {"status", Name(rig.status)},
          {"reason", rig.reason},
          {"epoch", rig.epoch},
          {"wear_s", rig.wear.count() / 1000}};
}

/// Runs one operator's input on a rig and logs it.
template <typename Input>
core::Result<HttpResponse> OnRig(Api& api,
                                 const ApiRequest& request,
                                 const std::string& verb,
                                 const std::string& detail,
                                 const Input& input) {
  const std::string& id = request.http.PathParameter("id");
  TRY_DONE(api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
    return input(scheduler, id, now);
  }));
  api.audit.Add(request.who, verb, "rig:" + id, detail);
  return JsonResponse(RigToJson(api.service.state()->rigs.at(id)));
}

/// Begins the check of a ready rig, or of one in quarantine, which does `extra` besides.
core::Result<HttpResponse> BeginCheck(Api& api,
                                      const ApiRequest& request,
                                      const std::string& verb,
                                      const std::string& detail,
                                      CheckExtra extra) {
  return OnRig(api,
               request,
               verb,
               detail,
               [&](lab::Scheduler& scheduler, const std::string& id, WallTime now) -> core::Status {
                 const auto rig = scheduler.state().rigs.find(id);
                 const bool out = rig != scheduler.state().rigs.end() &&
                                  rig->second.status == lab::RigStatus::kQuarantined;
                 TRY_DONE(out ? scheduler.Release(id, now) : scheduler.Recheck(id, now));
                 api.with_next_check(id, extra);
                 return core::Done{};
               });
}

core::Result<HttpResponse> ListRigClasses(Api& api, const ApiRequest&) {
  const auto state = api.service.state();
  std::map<std::string, json::object> classes;
  for (const auto& [id, rig] : state->rigs) {
    json::object& entry = classes[rig.rig_class];
    if (entry.empty()) {
      entry = {{"id", rig.rig_class},
               {"rigs", 0},
               {"ready", 0},
               {"waiting", 0},
               {"elastic", rig.elastic},
               {"members", json::array()}};
    }
    entry["rigs"] = entry["rigs"].as_int64() + 1;
    if (rig.status == lab::RigStatus::kReady) entry["ready"] = entry["ready"].as_int64() + 1;
    entry["members"].as_array().push_back(RigToJson(rig));
  }
  for (const auto& [id, ticket] : state->tickets) {
    const auto found = classes.find(ticket.rig_class);
    if (found == classes.end() || ticket.state != lab::TicketState::kWaiting) continue;
    found->second["waiting"] = found->second["waiting"].as_int64() + 1;
  }
  json::array items;
  for (auto& [name, entry] : classes) items.push_back(std::move(entry));
  return ListAnswer(std::move(items));
}

json::object RefusalToJson(const core::Error& error) {
  json::object parameters;
  for (const core::ErrorParameter& each : error.parameters) parameters[each.name] = each.value;
  return {{"message", error.message}, {"reason", error.reason}, {"parameters", parameters}};
}

core::Result<HttpResponse> GetAvailability(Api& api, const ApiRequest& request) {
  const WallTime now = api.clock.Wall();
  TRY(const auto asked_from, QueryTime(request.http, "from"));
  const WallTime from = asked_from.value_or(now);
  TRY(const auto asked_to, QueryTime(request.http, "to"));
  const WallTime to = asked_to.value_or(from + std::chrono::hours(24 * 7));
  if (to <= from || to - from > kRangeMax) {
    return core::Refuse("range_too_long", "to");
  }
  TRY(auto minutes, QueryInteger(request.http, "minutes", 30, 5, 1440));
  TRY(auto step, QueryInteger(request.http, "step", minutes, 5, 1440));
  const std::string& rig_class = request.http.PathParameter("rig_class");
  const auto state = api.service.state();
  if (!lab::HasClass(*state, rig_class)) return core::Refuse("no_rig_class");
  const lab::Policy& policy = api.service.policy();
  const Interval range{from, to};

  json::array busy;
  const lab::UserId me{request.who.user_id};
  for (const auto& [id, rig] : state->rigs) {
    if (rig.rig_class != rig_class) continue;
    for (const auto& [outage_id, outage] : state->outages) {
      if (outage.rig != id || !outage.during.Overlaps(range)) continue;
      json::object item = IntervalToJson(outage.during, "outage");
      item["rig"] = id;
      item["reason"] = outage.reason;
      busy.push_back(std::move(item));
    }
  }
  std::vector<Interval> taken;
  TRY(const auto courses, api.accounts.CoursesOf(request.who.user_id));
  for (const lab::Shut& shut : lab::ShutTimes(*state, rig_class, courses, range)) {
    taken.push_back(shut.during);
    json::object item = IntervalToJson(shut.during, shut.of == nullptr ? "closed" : "course");
    item["rig"] = "";
    if (shut.of != nullptr) item["reason"] = shut.of->title;
    busy.push_back(std::move(item));
  }
  for (const auto& [id, booking] : state->bookings) {
    const bool mine = booking.user == me && me != lab::UserId{};
    if (mine) taken.push_back(booking.during);
    if (booking.state == lab::BookingState::kWaiting) continue;
    if (booking.rig_class != rig_class || !booking.during.Overlaps(range)) continue;
    json::object item = IntervalToJson(booking.during, mine ? "mine" : "booking");
    item["rig"] = booking.rig;
    busy.push_back(std::move(item));
  }
  for (const auto& [id, session] : state->sessions) {
    const Interval during{session.start, session.hard_end};
    const bool shown = session.rig_class == rig_class && session.booking == lab::BookingId{} &&
                       session.state != lab::SessionState::kClosed && during.Overlaps(range);
    if (!shown) continue;
    json::object item =
        IntervalToJson(during, session.user == me && me != lab::UserId{} ? "mine" : "booking");
    item["rig"] = session.rig;
    busy.push_back(std::move(item));
  }
  const auto length = std::chrono::minutes(minutes);
  const Interval ahead{std::max(range.start, FirstStartToOffer(now)), range.end};
  // Nothing is offered that a booking would be refused; where nothing is left, the reason is told.
  std::optional<lab::Scheduler> asked;
  if (me != lab::UserId{}) asked.emplace(policy, *state);
  json::value refusal;
  const auto may = [&](const Interval& slot) {
    const core::Status checked =
        asked ? asked->CheckBooking(me, rig_class, slot, now, courses) : core::Status(core::Done{});
    if (!checked.ok()) refusal = RefusalToJson(checked.error());
    return checked.ok();
  };
  json::array next_free;
  for (const WallTime start :
       lab::NextFree(*state, rig_class, ahead, length, 10, now, policy, taken)) {
    if (!may({start, start + length})) continue;
    next_free.push_back(json::object{{"start", Iso8601(start)}, {"end", Iso8601(start + length)}});
  }
  json::array slots;
  bool any = !next_free.empty();
  const auto every = std::chrono::minutes(step);
  for (const lab::Slot& slot :
       lab::Availability(*state, rig_class, range, every, length, now, policy, taken)) {
    const int free = slot.free > 0 && may(slot.during) ? slot.free : 0;
    any = any || free > 0;
    slots.push_back(json::object{{"start", Iso8601(slot.during.start)}, {"free", free}});
  }
  return JsonResponse(json::object{{"busy", std::move(busy)},
                                   {"next_free", std::move(next_free)},
                                   {"slots", std::move(slots)},
                                   {"refusal", any ? json::value() : refusal},
                                   {"check_s", policy.cleaning.count() / 1000}});
}

json::object ContactsToJson(const RigContacts& contacts) {
  const auto finding_to_json = [](const hardware::ContactFinding& finding) {
    return json::object{{"component", core::Name(finding.component)},
                        {"value", finding.value},
                        {"line", finding.line},
                        {"contact", Name(finding.contact)},
                        {"um_expected_v", NumberOrNull(finding.um_expected_v)},
                        {"um_seen_v", NumberOrNull(finding.um_seen_v)},
                        {"ia_expected_a", NumberOrNull(finding.ia_expected_a)},
                        {"ia_seen_a", NumberOrNull(finding.ia_seen_a)},
                        {"text", finding.text}};
  };
  return {{"checked", Iso8601(contacts.checked)},
          {"ok", contacts.report.ok},
          {"nominal", contacts.report.nominal},
          {"positions", ListOf(contacts.report.positions, finding_to_json)}};
}

core::Result<HttpResponse> GetRigHealth(Api& api, const ApiRequest& request) {
  const auto state = api.service.state();
  const auto rig = state->rigs.find(request.http.PathParameter("id"));
  if (rig == state->rigs.end()) {
    return core::Refuse("no_rig", "", {{"rig", request.http.PathParameter("id")}});
  }
  json::object out = RigToJson(rig->second);
  json::array outages;
  for (const auto& [id, outage] : state->outages) {
    if (outage.rig != rig->first) continue;
    json::object item = IntervalToJson(outage.during, "outage");
    item["id"] = Number(id);
    item["reason"] = outage.reason;
    outages.push_back(std::move(item));
  }
  out["outages"] = std::move(outages);
  if (const std::optional<RigContacts> contacts = api.contacts_of(rig->first)) {
    out["contacts"] = ContactsToJson(*contacts);
  }
  return JsonResponse(out);
}

/// {"reason": "..."}, which says something.
core::Result<std::string> ReasonOf(const ApiRequest& request) {
  ObjectReader in(request.body, "");
  std::string reason = in.Text("reason", 500);
  if (auto error = in.Finish()) return *error;
  if (reason.find_first_not_of(" \t\r\n") != std::string::npos) return reason;
  return core::Refuse("reason_missing", "/reason");
}

core::Result<HttpResponse> QuarantineRig(Api& api, const ApiRequest& request) {
  TRY(const auto reason, ReasonOf(request));
  return OnRig(api,
               request,
               "quarantine",
               reason,
               [&](lab::Scheduler& scheduler, const std::string& id, WallTime now) {
                 return scheduler.Quarantine(id, reason, now);
               });
}

core::Result<HttpResponse> ReleaseRig(Api& api, const ApiRequest& request) {
  return OnRig(api,
               request,
               "release",
               "",
               [](lab::Scheduler& scheduler, const std::string& id, WallTime now) {
                 return scheduler.Release(id, now);
               });
}

core::Result<HttpResponse> TestRig(Api& api, const ApiRequest& request) {
  return OnRig(api,
               request,
               "self_test",
               "",
               [&](lab::Scheduler& scheduler, const std::string& id, WallTime now) -> core::Status {
                 const core::Status begun = scheduler.Recheck(id, now);
                 if (begun.ok()) api.with_next_check(id, CheckExtra::kContacts);
                 return begun;
               });
}

core::Result<HttpResponse> CommissionRig(Api& api, const ApiRequest& request) {
  TRY(const auto reason, ReasonOf(request));
  return BeginCheck(api, request, "commission", reason, CheckExtra::kCommission);
}

core::Result<HttpResponse> ClearTrip(Api& api, const ApiRequest& request) {
  TRY(const auto rig, api.rig_pool.Find(request.http.PathParameter("id")));
  if (!rig.trip) {
    return core::Refuse("no_interlock");
  }
  return BeginCheck(api, request, "clear_trip", "", CheckExtra::kClearTrip);
}

/// What the rig has seen is the agent's word, signed with the rig's key.
core::Result<HttpResponse> AdoptRig(Api& api, const ApiRequest& request) {
  TRY(const auto rig, api.rig_pool.Find(request.http.PathParameter("id")));
  TRY(const auto seen, EpochSeenBy(rig));
  return OnRig(api,
               request,
               "adopt",
               "seen epoch " + std::to_string(seen),
               [&](lab::Scheduler& scheduler, const std::string& id, WallTime now) {
                 return scheduler.Adopt(id, seen, now);
               });
}

core::Result<HttpResponse> CreateOutage(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string start_text = in.Text("start", 40);
  const std::string end_text = in.Text("end", 40);
  const std::string reason = in.TextOr("reason", "", 500);
  if (auto error = in.Finish()) return *error;
  TRY(const auto start, ParseIso8601(start_text, "/start"));
  TRY(const auto end, ParseIso8601(end_text, "/end"));
  const std::string& id = request.http.PathParameter("id");
  TRY(const auto outage, api.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.AddOutage(id, {start, end}, reason, now);
  }));
  api.audit.Add(request.who, "outage", "rig:" + id, start_text + " " + end_text + " " + reason);
  json::object out = IntervalToJson(outage.during, "outage");
  out["id"] = Number(outage.id);
  out["rig"] = id;
  out["reason"] = reason;
  return JsonResponse(out, 201);
}

core::Result<HttpResponse> DeleteOutage(Api& api, const ApiRequest& request) {
  TRY(auto outage, PathNumber(request, "outage"));
  const std::string& rig = request.http.PathParameter("id");
  const auto state = api.service.state();
  const auto found = state->outages.find(lab::OutageId{outage});
  if (found == state->outages.end() || found->second.rig != rig) {
    return core::Refuse("no_outage");
  }
  const lab::Outage& gone = found->second;
  const std::string planned =
      Iso8601(gone.during.start) + " " + Iso8601(gone.during.end) + " " + gone.reason;
  TRY_DONE(api.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.RemoveOutage(lab::OutageId{outage}, now);
  }));
  api.audit.Add(request.who, "remove_outage", "rig:" + rig, planned);
  return NoContent();
}

}  // namespace

std::span<const ApiRoute> RigsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "rig-classes", kListRigs, kRole, ListRigClasses},
      ApiRoute{kGet, "rig-classes/{rig_class}/availability", kListRigs, kRole, GetAvailability}
          .Takes("from to minutes step"),
      {kGet, "rigs/{id}/health", kListRigs, kRole, GetRigHealth},
      {kPost, "rigs/{id}/quarantine", kOperateRig, kRole, QuarantineRig, kJson},
      {kPost, "rigs/{id}/release", kOperateRig, kRole, ReleaseRig, kEmpty},
      {kPost, "rigs/{id}/self-test", kOperateRig, kRole, TestRig, kEmpty, kQuick, kRigsMember},
      {kPost,
       "rigs/{id}/commission",
       kOperateRig,
       kRole,
       CommissionRig,
       kJson,
       kQuick,
       kRigsMember},
      {kPost, "rigs/{id}/clear-trip", kOperateRig, kRole, ClearTrip, kEmpty, kQuick, kRigsMember},
      {kPost, "rigs/{id}/adopt", kOperateRig, kRole, AdoptRig, kEmpty, kQuick, kRigsMember},
      {kPost, "rigs/{id}/outages", kOperateRig, kRole, CreateOutage, kJson},
      {kDelete, "rigs/{id}/outages/{outage}", kOperateRig, kRole, DeleteOutage},
  });
  return kRoutes;
}

}  // namespace faultlab::server
