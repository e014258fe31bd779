// Who waits, and what a planned outage would do.
#include <boost/json.hpp>

#include "server/api/operate/handlers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::object WaitingToJson(Api& api, const lab::Ticket& ticket) {
  return {{"id", Number(ticket.id)},
          {"user", PersonToJson(api, Number(ticket.user))},
          {"rig_class", ticket.rig_class},
          {"kind", ticket.kind == lab::TicketKind::kJob ? "job" : "person"},
          {"state", Name(ticket.state)},
          {"place", ticket.place},
          {"since", Iso8601(ticket.created)},
          {"expected", TimeOrNull(ticket.expected)},
          {"want_s", ticket.want.count() / 1000}};
}

/// What becomes of the bookings and of the session when `after` follows `before`.
json::object EffectToJson(Api& api,
                          const lab::LabState& before,
                          const lab::LabState& after,
                          const std::string& rig) {
  json::array bookings;
  for (const auto& [id, booking] : before.bookings) {
    const auto then = after.bookings.find(id);
    const bool gone =
        then == after.bookings.end() || then->second.state == lab::BookingState::kUnfulfilled;
    const bool moved = !gone && then->second.rig != booking.rig;
    const bool was = booking.state == lab::BookingState::kUnfulfilled;
    if (was || booking.rig != rig || (!gone && !moved)) continue;
    bookings.push_back(
        json::object{{"id", Number(id)},
                     {"user", PersonToJson(api, Number(booking.user))},
                     {"start", Iso8601(booking.during.start)},
                     {"end", Iso8601(booking.during.end)},
                     {"outcome", gone ? "cancelled" : "moved"},
                     {"rig", gone ? json::value(nullptr) : json::value(then->second.rig)}});
  }
  json::array sessions;
  for (const auto& [id, session] : before.sessions) {
    const auto then = after.sessions.find(id);
    if (session.rig != rig || then == after.sessions.end()) continue;
    if (then->second.hard_end >= session.hard_end) continue;
    sessions.push_back(json::object{{"id", Number(id)},
                                    {"user", PersonToJson(api, Number(session.user))},
                                    {"end", Iso8601(then->second.hard_end)}});
  }
  return {{"bookings", std::move(bookings)}, {"sessions", std::move(sessions)}};
}

core::Result<HttpResponse> ListQueue(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  const auto state = api.service.state();
  json::array items;
  std::int64_t last = 0;
  for (auto each = state->tickets.upper_bound(lab::TicketId{page.after});
       each != state->tickets.end();
       ++each) {
    const lab::Ticket& ticket = each->second;
    if (ticket.state != lab::TicketState::kWaiting && ticket.state != lab::TicketState::kOffered) {
      continue;
    }
    if (static_cast<int>(items.size()) == page.limit) break;
    items.push_back(WaitingToJson(api, ticket));
    last = Number(ticket.id);
  }
  return page.Answer(std::move(items), last);
}

/// The lab's own rules decide, on a copy of its state.
core::Result<HttpResponse> PreviewOutage(Api& api, const ApiRequest& request) {
  TRY(const auto start, ParseIso8601(request.http.Query("start").value_or(""), "start"));
  TRY(const auto end, ParseIso8601(request.http.Query("end").value_or(""), "end"));
  const std::string& rig = request.http.PathParameter("id");
  const auto state = api.service.state();
  lab::Scheduler copy(api.service.policy(), *state);
  TRY_DONE(copy.AddOutage(rig, {start, end}, "", api.clock.Wall()));
  return JsonResponse(EffectToJson(api, *state, copy.state(), rig));
}

}  // namespace

std::span<const ApiRoute> OutlookRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "rigs/{id}/outages/preview", kOperateRig, kRole, PreviewOutage}.Takes(
          "start end"),
      ApiRoute{kGet, "queue", kOperateRig, kRole, ListQueue}.Takes("cursor limit"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
