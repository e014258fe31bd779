#include "server/api/sharing/handlers.h"
#include "server/api/sharing/person_feed.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(SharingApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  using enum AnswerSize;
  using enum LivesAt;
  const auto on = [&api](auto handler) { return On(api, handler); };
  return {
      {kGet, "/api/v1/rig-classes", kListRigs, kRole, on(ListRigClasses)},
      {kGet, "/api/v1/rig-classes/{class}/availability", kListRigs, kRole, on(GetAvailability)},
      {kGet, "/api/v1/rigs/{id}/health", kListRigs, kRole, on(GetRigHealth)},
      {kPost, "/api/v1/rigs/{id}/quarantine", kOperateRig, kRole, on(QuarantineRig), kJsonOnce},
      {kPost, "/api/v1/rigs/{id}/release", kOperateRig, kRole, on(ReleaseRig), kEmptyOnce},
      {kPost,
       "/api/v1/rigs/{id}/self-test",
       kOperateRig,
       kRole,
       on(TestRig),
       kEmptyOnce,
       kSmall,
       kRigsMember},
      {kPost,
       "/api/v1/rigs/{id}/commission",
       kOperateRig,
       kRole,
       on(CommissionRig),
       kJsonOnce,
       kSmall,
       kRigsMember},
      {kPost,
       "/api/v1/rigs/{id}/clear-trip",
       kOperateRig,
       kRole,
       on(ClearTrip),
       kEmptyOnce,
       kSmall,
       kRigsMember},
      {kPost,
       "/api/v1/rigs/{id}/adopt",
       kOperateRig,
       kRole,
       on(AdoptRig),
       kEmptyOnce,
       kSmall,
       kRigsMember},
      {kPost, "/api/v1/rigs/{id}/outages", kOperateRig, kRole, on(CreateOutage), kJsonOnce},
      {kDelete, "/api/v1/rigs/{id}/outages/{outage}", kOperateRig, kRole, on(DeleteOutage)},
      {kGet, "/api/v1/tickets", kUseTicket, kRole, on(ListTickets)},
      {kPost, "/api/v1/tickets", kUseTicket, kRole, on(CreateTicket), kJsonOnce},
      {kPost, "/api/v1/tickets/{id}/accept", kUseTicket, kRole, on(AcceptTicket), kEmpty},
      {kPost, "/api/v1/tickets/{id}/leave", kUseTicket, kRole, on(LeaveTicket), kEmpty},
      {kGet, "/api/v1/bookings", kUseBooking, kRole, on(ListBookings)},
      {kPost, "/api/v1/bookings", kUseBooking, kRole, on(CreateBooking), kJsonOnce},
      {kDelete, "/api/v1/bookings/{id}", kUseBooking, kRole, on(DeleteBooking)},
      {kPost, "/api/v1/bookings/{id}/claim", kUseBooking, kRole, on(ClaimBooking), kEmpty},
      {kGet, "/api/v1/calendar.ics", kUseBooking, kRole, on(GetCalendar)},
      {kGet, "/api/v1/calendar/{token}.ics", kReadPublic, kAnybody, on(GetCalendarByLink)},
      {kGet, "/api/v1/calendar-link", kManageOwnAccount, kRole, on(GetCalendarLink)},
      {kPost, "/api/v1/calendar-link", kManageOwnAccount, kRole, on(CreateCalendarLink), kEmpty},
      {kDelete, "/api/v1/calendar-link", kManageOwnAccount, kRole, on(RemoveCalendarLink)},
      {kGet, "/api/v1/events", kUseTicket, kRole, on(ListLabEvents)},
      {kPost, "/api/v1/events/stream-token", kUseTicket, kRole, on(IssueFeedToken), kEmpty},
      {kGet, "/api/v1/sessions", kUseSession, kRole, on(ListSessions)},
      {kPost, "/api/v1/sessions/{id}/extend", kUseSession, kRole, on(ExtendSession), kEmpty},
      {kPost, "/api/v1/sessions/{id}/end", kUseSession, kRole, on(EndSession), kEmpty},
      {kPost, "/api/v1/sessions/{id}/still-there", kUseSession, kRole, on(StillThere), kEmpty},
      {kPost, "/api/v1/sessions/{id}/handover", kUseSession, kRole, on(OfferControl), kJson},
      {kPost,
       "/api/v1/sessions/{id}/handover/accept",
       kUseSession,
       kRole,
       on(AcceptControl),
       kEmpty},
      {kPost, "/api/v1/sessions/{id}/take-over", kSpectate, kRole, on(TakeOverSession), kJson},
  };
}

}  // namespace faultlab::server
