// tickets, bookings, events.
#include <algorithm>
#include <array>
#include <boost/json.hpp>

#include "server/api/sharing/lists.h"
#include "server/api/sharing/recurrence.h"
#include "server/json/json_reader.h"
#include "server/lab/obstacles.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::BookingId;
using lab::TicketId;
using lab::UserId;

constexpr std::int64_t kDaySeconds = 86'400;

json::array ObstaclesToJson(const lab::LabState& state, const lab::Ticket& ticket, WallTime now) {
  json::array items;
  if (ticket.state != lab::TicketState::kWaiting) return items;
  for (const lab::Obstacle& obstacle : lab::ObstaclesOf(state, ticket, now)) {
    json::object item{{"rig", obstacle.rig}, {"kind", Name(obstacle.kind)}};
    if (obstacle.during.end != WallTime::max()) item["end"] = Iso8601(obstacle.during.end);
    if (obstacle.during.start != WallTime{}) item["start"] = Iso8601(obstacle.during.start);
    items.push_back(std::move(item));
  }
  return items;
}

json::object TicketToJson(const lab::LabState& state, const lab::Ticket& ticket, WallTime now) {
  json::object out{{"id", Number(ticket.id)},
                   {"rig_class", ticket.rig_class},
                   {"state", Name(ticket.state)},
                   {"place", ticket.place},
                   {"expected", TimeOrNull(ticket.expected)},
                   {"first_expected", TimeOrNull(ticket.first_expected)},
                   {"in_the_way", ObstaclesToJson(state, ticket, now)},
                   {"min_s", ticket.min.count() / 1000},
                   {"want_s", ticket.want.count() / 1000},
                   {"created_at", Iso8601(ticket.created)}};
  if (ticket.offered != lab::SessionId{}) out["session"] = Number(ticket.offered);
  return out;
}

json::object BookingToJson(const lab::Booking& booking) {
  json::object out{{"id", Number(booking.id)},
                   {"rig_class", booking.rig_class},
                   {"rig", booking.rig},
                   {"start", Iso8601(booking.during.start)},
                   {"end", Iso8601(booking.during.end)},
                   {"state", Name(booking.state)},
                   {"version", booking.version},
                   {"note", booking.note}};
  if (booking.session != lab::SessionId{}) out["session"] = Number(booking.session);
  return out;
}

/// The recording of what a person has lost: the newest of the session that has ended.
std::optional<std::string> RunBefore(Api& api, const lab::LabEvent& event) {
  constexpr std::array<std::string_view, 8> kLosses = {"taken_over",
                                                       "handed_over",
                                                       "idle_ended",
                                                       "expired",
                                                       "operator",
                                                       "rig_failed",
                                                       "booking_elsewhere",
                                                       "interrupted"};
  const bool loss = std::ranges::find(kLosses, event.topic) != kLosses.end();
  if (!loss || event.rig.empty()) return std::nullopt;
  const std::string owner = OwnerKeyOf(Number(event.user));
  const auto run = api.store.NewestOf(owner, event.rig, event.session_start, event.at);
  return run.ok() ? run.value() : std::nullopt;
}

HttpResponse BookingResponse(const lab::Booking& booking, int status) {
  return Versioned(JsonResponse(BookingToJson(booking), status), booking.version);
}

/// A signed-in person's tickets and bookings are theirs; operators may act on others'.
template <typename Map, typename Id>
core::Status MayUse(const Map& map, Id id, const Principal& who, Operation operation) {
  const auto found = map.find(id);
  if (found == map.end()) {
    return core::Refuse("nothing_here");
  }
  const bool own = found->second.user == UserId{who.user_id};
  return Authorize(who, operation, own ? Ownership::kOwn : Ownership::kForeign);
}

/// Local clock values without a zone do not exist in this feed: everything is UTC.

core::Result<HttpResponse> ListTickets(Api& api, const ApiRequest& request) {
  const auto state = api.service.state();
  const UserId user{request.who.user_id};
  HttpResponse response = ListAnswer(TicketsOf(*state, user, api.clock.Wall()));
  response.unsettled = std::ranges::any_of(state->tickets, [&](const auto& each) {
    return each.second.user == user && each.second.state == lab::TicketState::kWaiting;
  });
  return response;
}

core::Result<HttpResponse> CreateTicket(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  lab::TicketRequest wanted;
  wanted.user = UserId{request.who.user_id};
  wanted.rig_class = in.Text("rig_class", 64);
  wanted.min = std::chrono::seconds(in.IntegerOr("min_s", 600, 1, kDaySeconds));
  wanted.want = std::chrono::seconds(in.IntegerOr("want_s", 1800, 1, kDaySeconds));
  if (auto error = in.Finish()) return *error;
  TRY(wanted.courses, api.accounts.CoursesOf(request.who.user_id));
  TRY(const auto answer, api.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.RequestTicket(wanted, now);
  }));
  if (const auto* session = std::get_if<lab::Session>(&answer)) {
    return JsonResponse(json::object{{"session", SessionToJson(api, *session)}}, 201);
  }
  const auto state = api.service.state();
  const auto& ticket = std::get<lab::Ticket>(answer);
  return JsonResponse(json::object{{"ticket", TicketToJson(*state, ticket, api.clock.Wall())}},
                      201);
}

core::Result<HttpResponse> AcceptTicket(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY(const auto session, api.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.AcceptTicket(TicketId{id}, UserId{request.who.user_id}, now);
  }));
  return JsonResponse(SessionToJson(api, session));
}

core::Result<HttpResponse> LeaveTicket(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY_DONE(api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
    TRY_DONE(MayUse(scheduler.state().tickets, TicketId{id}, request.who, Operation::kUseTicket));
    return scheduler.LeaveTicket(TicketId{id}, now);
  }));
  return NoContent();
}

core::Result<HttpResponse> ListBookings(Api& api, const ApiRequest& request) {
  const auto state = api.service.state();
  return ListAnswer(BookingsOf(*state, UserId{request.who.user_id}));
}

/// @param again  the request may say how the time comes again
core::Result<std::vector<lab::Booking>> BookTimes(Api& api,
                                                  const ApiRequest& request,
                                                  ObjectReader& in,
                                                  bool again) {
  const std::string rig_class = in.Text("rig_class", 64);
  const bool wait = in.BooleanOr("wait", false);
  const Recurrence wanted = ReadRecurrence(in, again);
  if (auto error = in.Finish()) return *error;
  TRY(const auto times, TimesOf(wanted));
  TRY(const auto courses, api.accounts.CoursesOf(request.who.user_id));
  auto booked = api.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.BookAll(UserId{request.who.user_id}, rig_class, times, now, courses, wait);
  });
  if (booked) return std::move(booked).value();
  core::Error error = booked.error();
  if (!error.field.empty()) error.field = "/" + error.field;
  return error;
}

core::Result<HttpResponse> CreateBooking(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  TRY(const auto booked, BookTimes(api, request, in, /*again=*/false));
  HttpResponse response = BookingResponse(booked.front(), 201);
  response.headers.emplace_back("Location",
                                "/api/v1/bookings/" + std::to_string(Number(booked.front().id)));
  return response;
}

core::Result<HttpResponse> CreateBookings(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  TRY(const auto booked, BookTimes(api, request, in, /*again=*/true));
  HttpResponse response = ListAnswer(ListOf(booked, BookingToJson));
  response.status = 201;
  return response;
}

core::Result<HttpResponse> DeleteBooking(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY(auto version, RequiredVersion(request));
  TRY_DONE(api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
    TRY_DONE(
        MayUse(scheduler.state().bookings, BookingId{id}, request.who, Operation::kUseBooking));
    return scheduler.CancelBooking(BookingId{id}, version, now);
  }));
  return NoContent();
}

core::Result<HttpResponse> ClaimBooking(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY(const auto session, api.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.ClaimBooking(BookingId{id}, UserId{request.who.user_id}, now);
  }));
  return JsonResponse(SessionToJson(api, session));
}

core::Result<HttpResponse> ListLabEvents(Api& api, const ApiRequest& request) {
  TRY(auto since, QueryInteger(request.http, "since", 0, 0, INT64_MAX));
  TRY(auto limit, PageLimit(request.http));
  TRY(auto events, api.service.EventsSince(UserId{request.who.user_id}, since, limit));
  const std::int64_t next = events.empty() ? since : events.back().seq;
  return JsonUntilSettled(json::object{{"items", EventsToJson(api, events)}, {"next", next}},
                          !events.empty());
}

}  // namespace

json::array TicketsOf(const lab::LabState& state, UserId user, WallTime now) {
  json::array items;
  for (const auto& [id, ticket] : state.tickets) {
    if (ticket.user == user) items.push_back(TicketToJson(state, ticket, now));
  }
  return items;
}

json::array BookingsOf(const lab::LabState& state, UserId user) {
  json::array items;
  for (const auto& [id, booking] : state.bookings) {
    if (booking.user == user) items.push_back(BookingToJson(booking));
  }
  return items;
}

json::array EventsToJson(Api& api, std::span<const lab::LabEvent> events) {
  json::array items;
  for (const lab::LabEvent& event : events) {
    json::object item{{"id", event.seq},
                      {"topic", event.topic},
                      {"text", event.text},
                      {"session", Number(event.session)},
                      {"at", Iso8601(event.at)}};
    if (!event.rig.empty()) item["rig"] = event.rig;
    if (!event.why.empty()) item["why"] = event.why;
    if (!event.reason.empty()) item["reason"] = event.reason;
    if (event.time) item["time"] = Iso8601(*event.time);
    if (const auto run = RunBefore(api, event)) item["run"] = *run;
    if (event.other != UserId{}) {
      const auto account = api.accounts.Get(Number(event.other));
      if (account) {
        const Account& user = account.value();
        item["who"] = user.name.empty() ? user.login : user.name;
      }
    }
    items.push_back(std::move(item));
  }
  return items;
}

std::span<const ApiRoute> QueueRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "tickets", kUseTicket, kRole, ListTickets}.Takes("wait"),
      {kPost, "tickets", kUseTicket, kRole, CreateTicket, kJson},
      {kPost, "tickets/{id}/accept", kUseTicket, kRole, AcceptTicket, kEmpty},
      {kPost, "tickets/{id}/leave", kUseTicket, kRole, LeaveTicket, kEmpty},
      {kGet, "bookings", kUseBooking, kRole, ListBookings},
      {kPost, "bookings", kUseBooking, kRole, CreateBooking, kJson},
      {kPost, "bookings/series", kUseBooking, kRole, CreateBookings, kJson},
      {kDelete, "bookings/{id}", kUseBooking, kRole, DeleteBooking},
      {kPost,
       "bookings/{id}/claim",
       kUseBooking,
       kRole,
       ClaimBooking,
       kEmpty,
       kQuick,
       kBookingsMember},
      ApiRoute{kGet, "events", kUseTicket, kRole, ListLabEvents}.Takes("since limit wait"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
