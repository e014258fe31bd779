#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/api/api.h"
#include "server/auth/accounts.h"
#include "server/lab/fault_sets.h"
#include "server/lab/job_store.h"
#include "server/lab/lab_service.h"
#include "server/lab/remembered_answers.h"

namespace faultlab::server {

class CalendarLinks;
class LabFeed;

/// kCommission: its figures become the rig's band. kClearTrip: it opens the latch of an interlock
/// first.
enum class CheckExtra { kCommission, kClearTrip };

/// What the endpoints of accounts, queue, calendar, jobs and fault sets work on.
struct LabApi {
  Accounts& accounts;
  lab::LabService& service;
  lab::JobStore& jobs;
  lab::FaultSets& fault_sets;
  lab::RememberedAnswers& answers;
  CalendarLinks& calendar_links;
  LabFeed* feed = nullptr;
  /// What the next check of this rig does besides. Then ask for a check.
  std::function<void(const std::string& rig, CheckExtra extra)> with_next_check{};
  bool secure_cookies = false;  ///< the site is reached by https only
  std::function<void(std::string_view)> log = [](std::string_view) {};
};

/// The table of these endpoints: routes.cc. Each refuses with 404 while ApiContext::lab is
/// null.
std::vector<ApiRoute> LabRoutes();

/// The faults of the body's "fault_set" in the place of "faults"; the body as it is when it names
/// none. The set counts as used from then on.
core::Result<std::string> ExpandFaultSet(ApiContext& api,
                                         const Principal& who,
                                         std::string_view body);

// For handlers.

core::Result<LabApi*> LabOf(ApiContext& api);
/// The number in the path's {id}; kNotFound when it is none.
core::Result<std::int64_t> PathNumber(const ApiRequest& request, std::string_view name = "id");
/// The version in If-Match: "3". kInvalid with field If-Match when it is missing.
core::Result<std::int64_t> RequiredVersion(const ApiRequest& request);
/// Whose object `owner_key` names, seen from `who`; kCourse for teachers of its owner. Without
/// accounts everything not one's own is kForeign.
core::Result<Ownership> RelationTo(ApiContext& api,
                                   const Principal& who,
                                   std::string_view owner_key);
/// The set, if `who` may do `operation` on it.
core::Result<lab::FaultSet> AuthorizedFaultSet(ApiContext& api,
                                               const Principal& who,
                                               std::int64_t id,
                                               Operation operation);
/// An object {} without any member, for actions.
core::Status NoBody(const ApiRequest& request);
HttpResponse NoContent();
void Audit(ApiContext& api,
           const Principal& who,
           const std::string& verb,
           const std::string& object,
           const std::string& detail);

/// Runs `Handler` once for each Idempotency-Key of a signed-in caller: the same request again gets
/// the same answer, another request with the key is refused. Without the header: just runs it.
core::Result<HttpResponse> Remembered(ApiContext& api,
                                      const ApiRequest& request,
                                      ApiHandler handler);
template <ApiHandler Handler>
core::Result<HttpResponse> Once(ApiContext& api, const ApiRequest& request) {
  return Remembered(api, request, Handler);
}

// sign_in.cc
core::Result<HttpResponse> SignIn(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> SignOut(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ChangePassword(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> UseResetLink(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListApiKeys(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateApiKey(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> RevokeApiKey(ApiContext& api, const ApiRequest& request);

// people.cc
core::Result<HttpResponse> ListUsers(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateUser(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ChangeUser(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateResetLink(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListAuditLog(ApiContext& api, const ApiRequest& request);
boost::json::object UserToJson(const Account& account);

// courses.cc
core::Result<HttpResponse> ListCourses(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateCourse(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> SetCourseEnd(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListMembers(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> EnrolMembers(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListCourseInvitations(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListInvitations(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptInvitation(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> DeclineInvitation(ApiContext& api, const ApiRequest& request);

// rigs.cc
core::Result<HttpResponse> ListRigClasses(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetAvailability(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetRigHealth(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> QuarantineRig(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ReleaseRig(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> TestRig(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CommissionRig(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ClearTrip(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> AdoptRig(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateOutage(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteOutage(ApiContext& api, const ApiRequest& request);

// queue.cc
core::Result<HttpResponse> ListTickets(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateTicket(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptTicket(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> LeaveTicket(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListBookings(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateBooking(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteBooking(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ClaimBooking(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListLabEvents(ApiContext& api, const ApiRequest& request);

// calendar.cc
core::Result<HttpResponse> GetCalendar(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetCalendarByLink(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetCalendarLink(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateCalendarLink(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> RemoveCalendarLink(ApiContext& api, const ApiRequest& request);

// sessions.cc
core::Result<HttpResponse> ListSessions(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ExtendSession(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> EndSession(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> StillThere(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> OfferControl(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptControl(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> TakeOverSession(ApiContext& api, const ApiRequest& request);
boost::json::object SessionToJson(ApiContext& api, const lab::Session& session);

// jobs.cc
core::Result<HttpResponse> ListJobs(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateJobs(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetJob(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CancelJob(ApiContext& api, const ApiRequest& request);

// fault_sets.cc
core::Result<HttpResponse> ListFaultSets(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> CreateFaultSet(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ChangeFaultSet(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteFaultSet(ApiContext& api, const ApiRequest& request);

// isolability.cc
core::Result<HttpResponse> GetIsolability(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetIsolabilityPlot(ApiContext& api, const ApiRequest& request);

}  // namespace faultlab::server
