#pragma once

#include <boost/json/object.hpp>
#include <functional>
#include <optional>
#include <string>

#include "hardware/contact_check.h"
#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/auth/calendar_links.h"
#include "server/lab/lab_service.h"
#include "server/run/rig_pool.h"
#include "server/run/run_manager.h"

// Rigs as operators see them, and how people share them: queue, bookings, sessions, calendar.
namespace faultlab::server {

class PersonFeed;

/// kCommission: its figures become the rig's band. kClearTrip: it opens the latch of an interlock
/// first. kContacts: each relay position is recognised by its effect, if the rig has no others.
enum class CheckExtra { kCommission, kClearTrip, kContacts };

/// The relay positions of a rig when they were last recognised by their effect.
struct RigContacts {
  WallTime checked;
  hardware::ContactReport report;
};

struct SharingApi {
  lab::LabService& service;
  Accounts& accounts;
  RigPool& rig_pool;
  RunManager& runs;
  RecordingStore& store;
  CalendarLinks& calendar_links;
  StreamHub& hub;
  StreamTokens& tokens;
  AuditLog& audit;
  const Clock& clock;
  /// What the next check of this rig does besides. Then ask for a check.
  std::function<void(const std::string& rig, CheckExtra extra)> with_next_check;
  /// Of this member's checks since it started.
  std::function<std::optional<RigContacts>(const std::string& rig)> contacts_of = {};
  PersonFeed* feed = nullptr;
};

std::vector<ApiRoute> RoutesOf(SharingApi& api);

// rigs.cc
core::Result<HttpResponse> ListRigClasses(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetAvailability(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetRigHealth(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> QuarantineRig(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> ReleaseRig(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> TestRig(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> CommissionRig(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> ClearTrip(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> AdoptRig(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateOutage(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteOutage(SharingApi& api, const ApiRequest& request);

// policy.cc
core::Result<HttpResponse> GetPolicy(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> ChangePolicy(SharingApi& api, const ApiRequest& request);

// queue.cc
core::Result<HttpResponse> ListTickets(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateTicket(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptTicket(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> LeaveTicket(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListBookings(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateBooking(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteBooking(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> ClaimBooking(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListLabEvents(SharingApi& api, const ApiRequest& request);

// calendar.cc
core::Result<HttpResponse> GetCalendar(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetCalendarByLink(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetCalendarLink(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateCalendarLink(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> RemoveCalendarLink(SharingApi& api, const ApiRequest& request);

// sessions.cc
core::Result<HttpResponse> ListSessions(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> ExtendSession(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> EndSession(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> StillThere(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> OfferControl(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptControl(SharingApi& api, const ApiRequest& request);
core::Result<HttpResponse> TakeOverSession(SharingApi& api, const ApiRequest& request);
boost::json::object SessionToJson(SharingApi& api, const lab::Session& session);

}  // namespace faultlab::server
