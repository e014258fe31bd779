#include "server/auth/authorization.h"

#include <array>
#include <string>

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

/// One line per operation. In each column the letters state on which objects the role may do it: n
/// = collection or new object, o = own, c = of a course that the caller teaches (attends, for fault
/// sets), f = foreign.
struct Rule {
  Operation operation;
  std::string_view name;
  std::string_view scope;  ///< that an API key must have
  Operation seen_by;       ///< whoever may do this may know that the object exists
  std::array<std::string_view, kRoleCount> allowed;
};

// clang-format off
constexpr std::array<Rule, kOperationCount> kMatrix = {{
    //                                                                                                      guest   student instructor operator admin   service
    {Operation::kReadPublic,      "read_public",       "",           Operation::kReadPublic,      {"nocf", "nocf", "nocf", "nocf", "nocf", "nocf"}},
    {Operation::kListRigs,        "list_rigs",         "",           Operation::kListRigs,        {"nocf", "nocf", "nocf", "nocf", "nocf", "nocf"}},
    {Operation::kStartRun,        "start_run",         "runs:write", Operation::kReadRun,         {"no",   "no",   "no",   "no",   "no",   "no"}},
    {Operation::kReadRun,         "read_run",          "runs:read",  Operation::kReadRun,         {"no",   "no",   "noc",  "nocf", "nocf", "no"}},
    {Operation::kChangeRun,       "change_run",        "runs:write", Operation::kReadRun,         {"o",    "o",    "oc",   "ocf",  "ocf",  "o"}},
    {Operation::kDeleteRun,       "delete_run",        "runs:write", Operation::kReadRun,         {"o",    "o",    "o",    "o",    "ocf",  "o"}},
    {Operation::kUploadRecording, "upload_recording",  "runs:write", Operation::kReadRun,         {"n",    "n",    "n",    "n",    "n",    "n"}},
    {Operation::kManageOwnAccount,"manage_own_account","",           Operation::kManageOwnAccount,{"",     "no",   "no",   "no",   "no",   ""}},
    {Operation::kReadUsers,       "read_users",        "",           Operation::kReadUsers,       {"",     "o",    "oc",   "nocf", "nocf", ""}},
    {Operation::kManageUsers,     "manage_users",      "",           Operation::kReadUsers,       {"",     "",     "",     "",     "nocf", ""}},
    {Operation::kReadCourse,      "read_course",       "lab",        Operation::kReadCourse,      {"",     "noc",  "noc",  "nocf", "nocf", "noc"}},
    {Operation::kManageCourse,    "manage_course",     "",           Operation::kReadCourse,      {"",     "",     "no",   "",     "nocf", ""}},
    {Operation::kUseTicket,       "use_ticket",        "lab",        Operation::kUseTicket,       {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kUseBooking,      "use_booking",       "lab",        Operation::kUseBooking,      {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kUseSession,      "use_session",       "lab",        Operation::kUseSession,      {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kTakeOverSession, "take_over_session", "",           Operation::kSpectate,        {"",     "",     "c",    "cf",   "cf",   ""}},
    {Operation::kSpectate,        "spectate",          "runs:read",  Operation::kSpectate,        {"",     "no",   "noc",  "nocf", "nocf", "no"}},
    {Operation::kSubmitJob,       "submit_job",        "jobs",       Operation::kSubmitJob,       {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kReadFaultSet,    "read_fault_set",    "lab",        Operation::kReadFaultSet,    {"",     "noc",  "noc",  "nocf", "nocf", "noc"}},
    {Operation::kManageFaultSet,  "manage_fault_set",  "",           Operation::kReadFaultSet,    {"",     "",     "no",   "",     "nocf", ""}},
    {Operation::kOperateRig,      "operate_rig",       "",           Operation::kListRigs,        {"",     "",     "",     "nocf", "nocf", ""}},
    {Operation::kReadAudit,       "read_audit",        "",           Operation::kReadAudit,       {"",     "",     "",     "nocf", "nocf", ""}},
    {Operation::kReadMetrics,     "read_metrics",      "",           Operation::kReadMetrics,     {"nocf", "nocf", "nocf", "nocf", "nocf", "nocf"}},
}};
// clang-format on

constexpr bool LinesStandInTheOrderOfTheEnum() {
  for (std::size_t i = 0; i < kMatrix.size(); ++i) {
    if (static_cast<std::size_t>(kMatrix[i].operation) != i) return false;
  }
  return true;
}
static_assert(LinesStandInTheOrderOfTheEnum());

const Rule& RuleOf(Operation operation) {
  return kMatrix[static_cast<std::size_t>(operation)];
}

}  // namespace

std::string_view Name(Operation operation) {
  return RuleOf(operation).name;
}

std::string_view ScopeOf(Operation operation) {
  return RuleOf(operation).scope;
}

bool Allowed(Role role, Operation operation, Ownership ownership) {
  constexpr std::array<char, kOwnershipCount> kLetters = {'n', 'o', 'c', 'f'};
  const std::string_view allowed = RuleOf(operation).allowed[static_cast<std::size_t>(role)];
  return allowed.find(kLetters[static_cast<std::size_t>(ownership)]) != std::string_view::npos;
}

core::Status Authorize(const Principal& principal, Operation operation, Ownership ownership) {
  const Rule& rule = RuleOf(operation);
  if (Allowed(principal.role, operation, ownership)) {
    const bool needs_scope = principal.proof == Proof::kApiKey && !rule.scope.empty();
    if (!needs_scope || principal.scopes.contains(std::string(rule.scope))) return core::Done{};
    return Error{
        ErrorCode::kForbidden, "this API key lacks the scope " + std::string(rule.scope), ""};
  }
  if (principal.role == Role::kGuest) {
    return Error{ErrorCode::kUnauthorized, "sign in first", ""};
  }
  const bool of_others = ownership == Ownership::kCourse || ownership == Ownership::kForeign;
  if (of_others && !Allowed(principal.role, rule.seen_by, ownership)) {
    return Error{ErrorCode::kNotFound, "no such thing, or not yours to see", ""};
  }
  return Error{
      ErrorCode::kForbidden,
      "the role " + std::string(Name(principal.role)) + " may not " + std::string(rule.name),
      ""};
}

Ownership OwnershipOf(const Principal& who, std::string_view owner_key) {
  return owner_key == who.owner_key() ? Ownership::kOwn : Ownership::kForeign;
}

}  // namespace faultlab::server
