#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "core/types/result.h"
#include "server/auth/principal.h"

namespace faultlab::server {

/// All operations of the API. An endpoint uses exactly one.
enum class Operation {
  kReadPublic,  ///< health, description, own identity
  kListRigs,    ///< rigs, their state, availability
  kStartRun,    ///< on a rig that the lab has granted
  kReadRun,     ///< record, samples, plots, export, live stream
  kChangeRun,   ///< rename, stop, command
  kDeleteRun,
  kUploadRecording,
  kManageOwnAccount,  ///< own password, own API keys
  kReadUsers,
  kManageUsers,
  kReadCourse,
  kManageCourse,  ///< create, enrol
  kUseTicket,     ///< ask for a place in the queue, accept, leave
  kUseBooking,
  kUseSession,  ///< extend, end, offer control
  kTakeOverSession,
  kSpectate,
  kSubmitJob,
  kReadFaultSet,
  kManageFaultSet,
  kOperateRig,  ///< outages, quarantine, self-test, maintenance
  kReadAudit,
  kReadMetrics,
  kManageWebhooks,  ///< of the lab, and learning platforms
  kUseWebhook,      ///< of one's own
  kManagePolicy,
};
inline constexpr int kOperationCount = 26;
std::string_view Name(Operation operation);

/// The owner of the object, relative to the caller.
enum class Ownership {
  kNone,     ///< a collection or a new object
  kOwn,      ///< the caller's
  kCourse,   ///< of somebody in a course that the caller teaches (or, for fault sets, attends)
  kForeign,  ///< somebody else's
};
inline constexpr int kOwnershipCount = 4;
/// kOwn or kForeign, without regard to courses.
Ownership OwnershipOf(const Principal& who, std::string_view owner_key);

/// The authorization matrix: role x operation x ownership, in one table (authorization.cc).
bool Allowed(Role role, Operation operation, Ownership ownership);

/// The scopes that an API key may have. With the last four it acts with the role of its account.
inline constexpr std::array<std::string_view, 8> kScopes = {
    "runs:read", "runs:write", "jobs", "lab", "operate", "people", "courses", "audit"};
/// The scope with which an API key may do this, if its account may: "" where it needs none.
/// nullopt: no key may.
std::optional<std::string_view> ScopeOfKeys(Operation operation);
/// Whether a key of this role with this scope could do anything more than one without.
bool MayHaveScope(Role role, std::string_view scope);

/// Checks the matrix and, for API keys, the scope. A refused guest gets kUnauthorized ("sign in
/// first"), others kForbidden; a foreign object that the caller may not even read is kNotFound, so
/// that ids cannot be probed.
core::Status Authorize(const Principal& principal, Operation operation, Ownership ownership);

}  // namespace faultlab::server
