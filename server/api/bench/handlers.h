#pragma once

#include <boost/json/object.hpp>
#include <functional>
#include <string>

#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/auth/calendar_links.h"
#include "server/lab/lab_service.h"
#include "server/run/rig_bay.h"
#include "server/run/run_manager.h"

// Rigs as operators see them, and how people share them: queue, bookings, sessions, calendar.
namespace faultlab::server {

class PersonFeed;

/// kCommission: its figures become the rig's band. kClearTrip: it opens the latch of an interlock
/// first.
enum class CheckExtra { kCommission, kClearTrip };

struct BenchApi {
  lab::LabService& service;
  Accounts& accounts;
  RigBay& bay;
  RunManager& runs;
  RecordingStore& store;
  CalendarLinks& calendar_links;
  StreamHub& hub;
  StreamTokens& tokens;
  const AuditLog& audit;
  const Clock& clock;
  /// What the next check of this rig does besides. Then ask for a check.
  std::function<void(const std::string& rig, CheckExtra extra)> with_next_check;
  PersonFeed* feed = nullptr;
};

std::vector<ApiRoute> RoutesOf(BenchApi& api);

// rigs.cc
core::Result<HttpResponse> ListRigClasses(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetAvailability(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetRigHealth(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> QuarantineRig(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> ReleaseRig(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> TestRig(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> CommissionRig(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> ClearTrip(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> AdoptRig(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateOutage(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteOutage(BenchApi& api, const ApiRequest& request);

// queue.cc
core::Result<HttpResponse> ListTickets(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateTicket(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptTicket(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> LeaveTicket(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListBookings(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateBooking(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteBooking(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> ClaimBooking(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListLabEvents(BenchApi& api, const ApiRequest& request);

// calendar.cc
core::Result<HttpResponse> GetCalendar(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetCalendarByLink(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetCalendarLink(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateCalendarLink(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> RemoveCalendarLink(BenchApi& api, const ApiRequest& request);

// sessions.cc
core::Result<HttpResponse> ListSessions(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> ExtendSession(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> EndSession(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> StillThere(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> OfferControl(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptControl(BenchApi& api, const ApiRequest& request);
core::Result<HttpResponse> TakeOverSession(BenchApi& api, const ApiRequest& request);
boost::json::object SessionToJson(BenchApi& api, const lab::Session& session);

}  // namespace faultlab::server
