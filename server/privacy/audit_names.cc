#include "server/privacy/audit_names.h"

#include <algorithm>
#include <string_view>

#include "server/storage/rows.h"

namespace faultlab::server {

template <typename Visit>
void Fields(AuditLine& line, Visit&& visit) {
  visit("seq", line.seq);
  visit("at_ms", line.at_ms);
  visit("actor", line.actor);
  visit("verb", line.verb);
  visit("object", line.object);
  visit("detail", line.detail);
}

namespace {

constexpr std::string_view kBetween = ", ";
constexpr std::string_view kNewName = "name ";

/// "ann, bob": the logins of a class list.
std::string WithoutLogin(std::string_view list, const std::string& login, const std::string& by) {
  std::string out;
  while (true) {
    const std::size_t end = std::min(list.find(kBetween), list.size());
    const std::string_view one = list.substr(0, end);
    out += one == login ? by : one;
    if (end == list.size()) return out;
    out += kBetween;
    list.remove_prefix(end + kBetween.size());
  }
}

/// "role student; name Ann": a new name is the last part of a change.
std::string WithoutName(const std::string& change, const std::string& by) {
  const std::size_t after = change.find("; " + std::string(kNewName));
  if (change.starts_with(kNewName)) return std::string(kNewName) + by;
  if (after == std::string::npos) return change;
  return change.substr(0, after + 2) + std::string(kNewName) + by;
}

std::string DetailWithout(const AuditLine& line,
                          const LoggedPerson& person,
                          const std::string& by) {
  if (line.verb == "enrol" || line.verb == "invite" || line.verb == "take_back") {
    return WithoutLogin(line.detail, person.login, by);
  }
  if (line.object == person.owner) {
    if (line.verb == "create_user") return by;
    if (line.verb == "change_user") return WithoutName(line.detail, by);
  }
  if (line.actor == person.owner) {
    if (line.verb == "accept_invitation" || line.verb == "decline_invitation") return by;
    if (line.verb == "create_key") return "";  // the name that the person gave to the key
  }
  return line.detail;
}

/// `faultlab admin` used to write a login into `object`; nothing else does.
bool ObjectIsLogin(const AuditLine& line) {
  return line.actor == "system" && line.detail == "faultlab admin" &&
         line.object.find(':') == std::string::npos;
}

void LockLog(Transaction& tx, bool locked) {
  if (tx.engine() == Engine::kPostgresql) {
    Execute(tx,
            std::string("ALTER TABLE audit_log ") + (locked ? "ENABLE" : "DISABLE") +
                " TRIGGER audit_log_is_append_only");
    return;
  }
  if (!locked) {
    Execute(tx, "DROP TRIGGER audit_log_is_append_only_1");
    return;
  }
  Execute(tx,
          "CREATE TRIGGER audit_log_is_append_only_1 BEFORE UPDATE ON audit_log "
          "BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END");
}

}  // namespace

std::optional<AuditLine> Renamed(AuditLine line,
                                 const LoggedPerson& person,
                                 const std::string& by) {
  std::string detail = DetailWithout(line, person, by);
  const bool by_login = ObjectIsLogin(line) && line.object == person.login;
  if (detail == line.detail && !by_login) return std::nullopt;
  line.detail = std::move(detail);
  if (by_login) line.object = person.owner;
  return line;
}

std::vector<AuditLine> LinesThatName(Transaction& tx, const LoggedPerson& person) {
  auto lines = SelectRows<AuditLine>(
      tx,
      "audit_log WHERE (verb IN ('enrol', 'invite', 'take_back') AND REPLACE(detail, :login, '') "
      "<> detail) OR "
      "(object = :person AND verb IN ('create_user', 'change_user')) OR "
      "(actor = :person AND verb IN ('accept_invitation', 'decline_invitation', 'create_key')) OR "
      "(actor = 'system' AND object = :login) ORDER BY seq",
      {{"login", person.login}, {"person", person.owner}});
  std::erase_if(lines, [&](const AuditLine& line) { return !Renamed(line, person, ""); });
  return lines;
}

void RenameInLog(Transaction& tx, const LoggedPerson& person, const std::string& by) {
  const std::vector<AuditLine> lines = LinesThatName(tx, person);
  if (lines.empty()) return;
  LockLog(tx, false);
  for (const AuditLine& line : lines) {
    const AuditLine renamed = Renamed(line, person, by).value_or(line);
    UpdateWhere(tx,
                "audit_log",
                {{"object", renamed.object}, {"detail", renamed.detail}},
                {{"seq", renamed.seq}});
  }
  LockLog(tx, true);
}

}  // namespace faultlab::server
