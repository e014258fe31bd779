#include "server/auth/authorization.h"
#include "server/storage/not_yours.h"

#include <algorithm>
#include <array>
#include <string>

namespace faultlab::server {
namespace {

using core::Error;

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
    {Operation::kReadUsers,       "read_users",        "people",     Operation::kReadUsers,       {"",     "o",    "oc",   "nocf", "nocf", ""}},
    {Operation::kManageUsers,     "manage_users",      "people",     Operation::kReadUsers,       {"",     "",     "",     "",     "nocf", ""}},
    {Operation::kReadCourse,      "read_course",       "lab",        Operation::kReadCourse,      {"",     "noc",  "noc",  "nocf", "nocf", "noc"}},
    {Operation::kManageCourse,    "manage_course",     "courses",    Operation::kReadCourse,      {"",     "",     "no",   "",     "nocf", ""}},
    {Operation::kUseTicket,       "use_ticket",        "lab",        Operation::kUseTicket,       {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kUseBooking,      "use_booking",       "lab",        Operation::kUseBooking,      {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kUseSession,      "use_session",       "lab",        Operation::kUseSession,      {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kTakeOverSession, "take_over_session", "",           Operation::kSpectate,        {"",     "",     "c",    "cf",   "cf",   ""}},
    {Operation::kSpectate,        "spectate",          "runs:read",  Operation::kSpectate,        {"",     "no",   "noc",  "nocf", "nocf", "no"}},
    {Operation::kSubmitJob,       "submit_job",        "jobs",       Operation::kSubmitJob,       {"",     "no",   "no",   "nocf", "nocf", "no"}},
    {Operation::kReadFaultSet,    "read_fault_set",    "lab",        Operation::kReadFaultSet,    {"",     "noc",  "noc",  "nocf", "nocf", "noc"}},
    {Operation::kManageFaultSet,  "manage_fault_set",  "courses",    Operation::kReadFaultSet,    {"",     "",     "no",   "",     "nocf", ""}},
    {Operation::kOperateRig,      "operate_rig",       "operate",    Operation::kListRigs,        {"",     "",     "",     "nocf", "nocf", ""}},
    {Operation::kReadAudit,       "read_audit",        "audit",      Operation::kReadAudit,       {"",     "",     "",     "nocf", "nocf", ""}},
    {Operation::kReadMetrics,     "read_metrics",      "",           Operation::kReadMetrics,     {"nocf", "nocf", "nocf", "nocf", "nocf", "nocf"}},
    {Operation::kManageWebhooks,  "manage_webhooks",   "",           Operation::kManageWebhooks,  {"",     "",     "",     "",     "nocf", ""}},
    {Operation::kUseWebhook,      "use_webhook",       "lab",        Operation::kUseWebhook,      {"",     "no",   "no",   "no",   "no",   "no"}},
    {Operation::kManagePolicy,    "manage_policy",     "operate",    Operation::kManagePolicy,    {"",     "",     "",     "",     "nocf", ""}},
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

/// Keys may do this only for an account whose role may: the column `service` is empty.
bool IsForStaff(const Rule& rule) {
  return rule.allowed[static_cast<std::size_t>(Role::kService)].empty();
}

/// Nothing is changed by it.
bool OnlyReads(const Rule& rule) {
  return rule.name.starts_with("read_") || rule.operation == Operation::kSpectate;
}

/// With the scope of the operation a key does what only staff may, and sees what its account sees
/// of its own and its courses.
Role RoleFor(const Principal& principal, const Rule& rule, Ownership ownership) {
  const bool lends = principal.proof == Proof::kApiKey && !rule.scope.empty() &&
                     (IsForStaff(rule) || (OnlyReads(rule) && ownership != Ownership::kForeign)) &&
                     principal.scopes.contains(std::string(rule.scope));
  return lends ? principal.account_role : principal.role;
}

Error ScopeLacking(const Rule& rule) {
  return core::Refuse("scope_lacking", "", {{"scope", rule.scope}});
}

}  // namespace

std::string_view Name(Operation operation) {
  return RuleOf(operation).name;
}

bool Allowed(Role role, Operation operation, Ownership ownership) {
  constexpr std::array<char, kOwnershipCount> kLetters = {'n', 'o', 'c', 'f'};
  const std::string_view allowed = RuleOf(operation).allowed[static_cast<std::size_t>(role)];
  return allowed.find(kLetters[static_cast<std::size_t>(ownership)]) != std::string_view::npos;
}

std::optional<std::string_view> ScopeOfKeys(Operation operation) {
  const Rule& rule = RuleOf(operation);
  if (IsForStaff(rule) && rule.scope.empty()) return std::nullopt;
  return rule.scope;
}

bool MayHaveScope(Role role, std::string_view scope) {
  return std::ranges::any_of(kMatrix, [&](const Rule& rule) {
    return rule.scope == scope &&
           (!IsForStaff(rule) || Allowed(role, rule.operation, Ownership::kNone));
  });
}

core::Status Authorize(const Principal& principal, Operation operation, Ownership ownership) {
  const Rule& rule = RuleOf(operation);
  if (Allowed(RoleFor(principal, rule, ownership), operation, ownership)) {
    const bool needs_scope = principal.proof == Proof::kApiKey && !rule.scope.empty();
    if (!needs_scope || principal.scopes.contains(std::string(rule.scope))) return core::Done{};
    return ScopeLacking(rule);
  }
  if (principal.proof == Proof::kApiKey && !rule.scope.empty() && IsForStaff(rule) &&
      Allowed(principal.account_role, operation, ownership)) {
    return ScopeLacking(rule);
  }
  if (principal.role == Role::kGuest) {
    return core::Refuse("sign_in_first");
  }
  const bool of_others = ownership == Ownership::kCourse || ownership == Ownership::kForeign;
  if (of_others && !Allowed(principal.role, rule.seen_by, ownership)) {
    return NotYours();
  }
  return core::Refuse(
      "role_may_not", "", {{"role", Name(principal.role)}, {"operation", rule.name}});
}

Ownership OwnershipOf(const Principal& who, std::string_view owner_key) {
  return owner_key == who.owner_key() ? Ownership::kOwn : Ownership::kForeign;
}

}  // namespace faultlab::server
