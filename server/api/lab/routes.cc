#include "server/api/lab/feed.h"

namespace faultlab::server {

std::vector<ApiRoute> LabRoutes() {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  return {
      {kPost, "/api/v1/auth/login", kReadPublic, kAnybody, SignIn, kSignInJson},
      {kPost, "/api/v1/auth/reset", kReadPublic, kAnybody, UseResetLink, kSignInJson},
      {kPost, "/api/v1/auth/logout", kManageOwnAccount, kRole, SignOut, kJson},
      {kPost, "/api/v1/auth/password", kManageOwnAccount, kRole, ChangePassword, kJson},
      {kGet, "/api/v1/api-keys", kManageOwnAccount, kRole, ListApiKeys},
      {kPost, "/api/v1/api-keys", kManageOwnAccount, kRole, CreateApiKey, kJson},
      {kDelete, "/api/v1/api-keys/{id}", kManageOwnAccount, kRole, RevokeApiKey},

      {kGet, "/api/v1/users", kReadUsers, kRole, ListUsers},
      {kPost, "/api/v1/users", kManageUsers, kRole, Once<CreateUser>, kJson},
      {kPatch, "/api/v1/users/{id}", kManageUsers, kRole, ChangeUser, kJson},
      {kPost, "/api/v1/users/{id}/reset-link", kManageUsers, kRole, CreateResetLink, kJson},
      {kGet, "/api/v1/courses", kReadCourse, kRole, ListCourses},
      {kPost, "/api/v1/courses", kManageCourse, kRole, Once<CreateCourse>, kJson},
      {kPut, "/api/v1/courses/{id}/end", kReadCourse, kRole, SetCourseEnd, kJson},
      {kGet, "/api/v1/courses/{id}/members", kReadCourse, kRole, ListMembers},
      {kPost, "/api/v1/courses/{id}/members", kReadCourse, kRole, EnrolMembers, kClassList},
      {kGet, "/api/v1/courses/{id}/invitations", kReadCourse, kRole, ListCourseInvitations},
      {kGet, "/api/v1/invitations", kManageOwnAccount, kRole, ListInvitations},
      {kPost,
       "/api/v1/invitations/{course}/accept",
       kManageOwnAccount,
       kRole,
       AcceptInvitation,
       kJson},
      {kPost,
       "/api/v1/invitations/{course}/decline",
       kManageOwnAccount,
       kRole,
       DeclineInvitation,
       kJson},
      {kGet, "/api/v1/audit", kReadAudit, kRole, ListAuditLog},

      {kGet, "/api/v1/rig-classes", kListRigs, kRole, ListRigClasses},
      {kGet, "/api/v1/rig-classes/{class}/availability", kListRigs, kRole, GetAvailability},
      {kGet, "/api/v1/rigs/{id}/health", kListRigs, kRole, GetRigHealth},
      {kPost, "/api/v1/rigs/{id}/quarantine", kOperateRig, kRole, Once<QuarantineRig>, kJson},
      {kPost, "/api/v1/rigs/{id}/release", kOperateRig, kRole, Once<ReleaseRig>, kJson},
      {kPost, "/api/v1/rigs/{id}/self-test", kOperateRig, kRole, Once<TestRig>, kJson},
      {kPost, "/api/v1/rigs/{id}/commission", kOperateRig, kRole, Once<CommissionRig>, kJson},
      {kPost, "/api/v1/rigs/{id}/clear-trip", kOperateRig, kRole, Once<ClearTrip>, kJson},
      {kPost, "/api/v1/rigs/{id}/adopt", kOperateRig, kRole, Once<AdoptRig>, kJson},
      {kPost, "/api/v1/rigs/{id}/outages", kOperateRig, kRole, Once<CreateOutage>, kJson},
      {kDelete, "/api/v1/rigs/{id}/outages/{outage}", kOperateRig, kRole, DeleteOutage},

      {kGet, "/api/v1/tickets", kUseTicket, kRole, ListTickets},
      {kPost, "/api/v1/tickets", kUseTicket, kRole, Once<CreateTicket>, kJson},
      {kPost, "/api/v1/tickets/{id}/accept", kUseTicket, kRole, AcceptTicket, kJson},
      {kPost, "/api/v1/tickets/{id}/leave", kUseTicket, kRole, LeaveTicket, kJson},
      {kGet, "/api/v1/bookings", kUseBooking, kRole, ListBookings},
      {kPost, "/api/v1/bookings", kUseBooking, kRole, Once<CreateBooking>, kJson},
      {kDelete, "/api/v1/bookings/{id}", kUseBooking, kRole, DeleteBooking},
      {kPost, "/api/v1/bookings/{id}/claim", kUseBooking, kRole, ClaimBooking, kJson},
      {kGet, "/api/v1/calendar.ics", kUseBooking, kRole, GetCalendar},
      {kGet, "/api/v1/calendar/{token}.ics", kReadPublic, kAnybody, GetCalendarByLink},
      {kGet, "/api/v1/calendar-link", kManageOwnAccount, kRole, GetCalendarLink},
      {kPost, "/api/v1/calendar-link", kManageOwnAccount, kRole, CreateCalendarLink, kJson},
      {kDelete, "/api/v1/calendar-link", kManageOwnAccount, kRole, RemoveCalendarLink},
      {kGet, "/api/v1/events", kUseTicket, kRole, ListLabEvents},
      {kPost, "/api/v1/events/stream-token", kUseTicket, kRole, IssueFeedToken, kJson},

      {kGet, "/api/v1/sessions", kUseSession, kRole, ListSessions},
      {kPost, "/api/v1/sessions/{id}/extend", kUseSession, kRole, ExtendSession, kJson},
      {kPost, "/api/v1/sessions/{id}/end", kUseSession, kRole, EndSession, kJson},
      {kPost, "/api/v1/sessions/{id}/still-there", kUseSession, kRole, StillThere, kJson},
      {kPost, "/api/v1/sessions/{id}/handover", kUseSession, kRole, OfferControl, kJson},
      {kPost, "/api/v1/sessions/{id}/handover/accept", kUseSession, kRole, AcceptControl, kJson},
      {kPost, "/api/v1/sessions/{id}/take-over", kSpectate, kRole, TakeOverSession, kJson},

      {kGet, "/api/v1/jobs", kSubmitJob, kRole, ListJobs},
      {kPost, "/api/v1/jobs", kSubmitJob, kRole, Once<CreateJobs>, kJson},
      {kGet, "/api/v1/jobs/{id}", kSubmitJob, kRole, GetJob},
      {kDelete, "/api/v1/jobs/{id}", kSubmitJob, kRole, CancelJob},

      {kGet, "/api/v1/fault-sets", kReadFaultSet, kRole, ListFaultSets},
      {kPost, "/api/v1/fault-sets", kManageFaultSet, kRole, Once<CreateFaultSet>, kJson},
      {kPut, "/api/v1/fault-sets/{id}", kManageFaultSet, kRole, ChangeFaultSet, kJson},
      {kDelete, "/api/v1/fault-sets/{id}", kManageFaultSet, kRole, DeleteFaultSet},
      {kGet, "/api/v1/fault-sets/{id}/isolability", kReadFaultSet, kRole, GetIsolability},
      {kGet, "/api/v1/fault-sets/{id}/isolability.png", kReadFaultSet, kRole, GetIsolabilityPlot},
  };
}

}  // namespace faultlab::server
