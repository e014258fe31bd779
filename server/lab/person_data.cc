#include "server/lab/person_data.h"

#include <soci/soci.h>

#include <array>
#include <cctype>
#include <charconv>

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

/// Where things of a person stand. `condition` has :id, the number of the account, or :owner, its
/// key "user:7".
struct Place {
  const char* table;
  const char* columns;
  const char* condition;
};

constexpr std::array kPlaces = {
    Place{"account", "id, login, name, role, disabled, created_ms", "id = :id"},
    Place{"sign_in", "created_ms, expires_ms, address", "account_id = :id"},
    Place{"known_device", "created_ms, used_ms", "account_id = :id"},
    Place{"external_identity", "issuer, subject, created_ms", "account_id = :id"},
    Place{"api_key", "id, name, scopes, created_ms, expires_ms, revoked", "account_id = :id"},
    Place{"one_time_link", "expires_ms, used", "account_id = :id"},
    Place{"calendar_link", "created_ms", "account_id = :id"},
    Place{"enrolment", "course_id, teaches", "account_id = :id"},
    Place{"course_invitation", "course_id, invited_by, created_ms", "account_id = :id"},
    Place{"recording",
          "id, name, rig, source, state, created_ms, ended_ms, samples, period_s, plan_json, "
          "diagnosis_json",
          "owner = :owner"},
    Place{"job", "id, name, state, body, result, error, created_ms, ended_ms", "owner = :owner"},
    Place{"fault_set", "id, course_id, name, faults, created_ms", "account_id = :id"},
    Place{"lab_ticket", "id, rig_class, created_ms, state", "user_id = :id"},
    Place{"lab_booking", "id, rig_class, rig, start_ms, end_ms, state, note", "user_id = :id"},
    Place{"lab_session", "id, rig, start_ms, hard_end_ms, state, end_text", "user_id = :id"},
    Place{"lab_usage", "seconds, at_ms", "user_id = :id"},
    Place{"lab_event", "at_ms, topic, text", "user_id = :id"},
    Place{"audit_log", "at_ms, actor, verb, object, detail", "actor = :owner OR object = :owner"},
};

std::string OwnerKey(std::int64_t account_id) {
  return "user:" + std::to_string(account_id);
}

std::string Text(const soci::row& row, std::size_t at) {
  if (row.get_indicator(at) == soci::i_null) return "";
  switch (row.get_properties(at).get_data_type()) {
    case soci::dt_string:
      return row.get<std::string>(at);
    case soci::dt_double: {
      std::array<char, 32> text;
      const auto end = std::to_chars(text.data(), text.data() + text.size(), row.get<double>(at));
      return {text.data(), end.ptr};
    }
    case soci::dt_integer:
      return std::to_string(row.get<int>(at));
    case soci::dt_long_long:
      return std::to_string(row.get<long long>(at));
    case soci::dt_unsigned_long_long:
      return std::to_string(row.get<unsigned long long>(at));
    default:
      return "?";
  }
}

/// A condition names one parameter several times, and SOCI binds each by its place.
std::string Bound(std::string condition, std::int64_t id, const std::string& owner) {
  const std::string number = std::to_string(id);
  const std::string quoted = "'" + owner + "'";  // "user:7": made here, of a number
  for (const auto& [word, by] :
       {std::pair{std::string(":id"), number}, std::pair{std::string(":owner"), quoted}}) {
    for (std::size_t at = condition.find(word); at != std::string::npos;
         at = condition.find(word, at + by.size())) {
      condition.replace(at, word.size(), by);
    }
  }
  return condition;
}

PersonTable Read(Transaction& tx, const Place& place, std::int64_t account_id) {
  PersonTable table{place.table, {}, {}};
  const std::string query = std::string("SELECT ") + place.columns + " FROM " + place.table +
                            " WHERE " + Bound(place.condition, account_id, OwnerKey(account_id)) +
                            " ORDER BY 1";
  const soci::rowset<soci::row> rows = (tx.sql().prepare << query);
  for (const soci::row& row : rows) {
    if (table.columns.empty()) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        table.columns.push_back(row.get_properties(i).get_name());
      }
    }
    std::vector<std::string>& texts = table.rows.emplace_back();
    for (std::size_t i = 0; i < row.size(); ++i) texts.push_back(Text(row, i));
  }
  return table;
}

/// What must end before its person can go.
core::Status CheckAtRest(Transaction& tx, std::int64_t account_id) {
  struct Living {
    const char* what;
    const char* from;
  };
  constexpr std::array kLiving = {
      Living{"a run in progress", "recording WHERE owner = :owner AND state = 'running'"},
      Living{"a session", "lab_session WHERE user_id = :id AND state < 2"},
      Living{"a place in a queue", "lab_ticket WHERE user_id = :id AND state < 2"},
      Living{"a booking", "lab_booking WHERE user_id = :id AND state = 0"},
      Living{"a job", "job WHERE owner = :owner AND state IN ('waiting', 'running')"}};
  for (const Living& living : kLiving) {
    std::int64_t count = 0;
    tx.sql() << "SELECT COUNT(*) FROM " + Bound(living.from, account_id, OwnerKey(account_id)),
        into(count);
    if (count == 0) continue;
    return Error{ErrorCode::kConflict,
                 std::string("this account has ") + living.what + "; end it first",
                 ""};
  }
  return Done{};
}

/// Whole words alone: "ann" stays in "anna".
std::string WithoutWord(std::string text, const std::string& word, const std::string& by) {
  const auto of_login = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("._@-").find(c) != std::string_view::npos;
  };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at)) {
    const std::size_t end = at + word.size();
    const bool whole =
        (at == 0 || !of_login(text[at - 1])) && (end == text.size() || !of_login(text[end]));
    if (whole) text.replace(at, word.size(), by);
    at += whole ? by.size() : 1;
  }
  return text;
}

void LockLog(Transaction& tx, bool locked) {
  if (tx.engine() == Engine::kPostgresql) {
    tx.sql() << std::string("ALTER TABLE audit_log ") + (locked ? "ENABLE" : "DISABLE") +
                    " TRIGGER audit_log_is_append_only";
    return;
  }
  if (!locked) {
    tx.sql() << "DROP TRIGGER audit_log_is_append_only_1";
    return;
  }
  tx.sql() << "CREATE TRIGGER audit_log_is_append_only_1 BEFORE UPDATE ON audit_log "
              "BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END";
}

/// The one change that the log takes: the login and name of who is erased.
void RenameInLog(Transaction& tx,
                 const std::string& login,
                 const std::string& name,
                 const std::string& by) {
  struct Line {
    std::int64_t seq = 0;
    std::string object;
    std::string detail;
  };
  std::vector<Line> lines;
  {
    const soci::rowset<soci::row> rows =
        (tx.sql().prepare << "SELECT seq, object, detail FROM audit_log");
    for (const soci::row& row : rows) {
      Line line{std::stoll(Text(row, 0)), row.get<std::string>(1), row.get<std::string>(2)};
      Line renamed{
          line.seq, WithoutWord(line.object, login, by), WithoutWord(line.detail, login, by)};
      if (!name.empty()) renamed.detail = WithoutWord(renamed.detail, name, by);
      if (renamed.object != line.object || renamed.detail != line.detail) lines.push_back(renamed);
    }
  }
  if (lines.empty()) return;
  LockLog(tx, false);
  for (const Line& line : lines) {
    tx.sql() << "UPDATE audit_log SET object = :object, detail = :detail WHERE seq = :seq",
        use(line.object, "object"), use(line.detail, "detail"), use(line.seq, "seq");
  }
  LockLog(tx, true);
}

}  // namespace

core::Result<std::vector<PersonTable>> PersonData(Database& database, std::int64_t account_id) {
  return database.Read([&](Transaction& tx) -> core::Result<std::vector<PersonTable>> {
    std::vector<PersonTable> tables;
    for (const Place& place : kPlaces) tables.push_back(Read(tx, place, account_id));
    return tables;
  });
}

core::Result<std::vector<std::string>> RecordingsOf(Database& database, std::int64_t account_id) {
  return database.Read([&](Transaction& tx) -> core::Result<std::vector<std::string>> {
    const std::string owner = OwnerKey(account_id);
    std::vector<std::string> ids;
    const soci::rowset<std::string> rows =
        (tx.sql().prepare << "SELECT id FROM recording WHERE owner = :owner ORDER BY created_ms",
         use(owner, "owner"));
    for (const std::string& id : rows) ids.push_back(id);
    return ids;
  });
}

core::Status ErasePerson(Database& database, std::int64_t account_id, WallTime now) {
  return database.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const core::Status at_rest = CheckAtRest(tx, account_id);
    if (!at_rest.ok()) return at_rest;
    const std::string owner = OwnerKey(account_id);
    const std::string own = "(SELECT id FROM recording WHERE owner = '" + owner + "')";
    tx.sql() << "DELETE FROM blob_store WHERE owner IN (SELECT 'recording:' || id FROM recording "
                "WHERE owner = :owner)",
        use(owner, "owner");
    tx.sql() << "DELETE FROM recording_event WHERE recording_id IN " + own;
    for (const char* table : {"recording", "job", "remembered_answer"}) {
      tx.sql() << std::string("DELETE FROM ") + table + " WHERE owner = :owner",
          use(owner, "owner");
    }
    for (const char* table : {"sign_in",
                              "known_device",
                              "external_identity",
                              "api_key",
                              "one_time_link",
                              "calendar_link",
                              "enrolment",
                              "course_invitation"}) {
      tx.sql() << std::string("DELETE FROM ") + table + " WHERE account_id = :id",
          use(account_id, "id");
    }
    tx.sql() << "DELETE FROM lab_event WHERE user_id = :id", use(account_id, "id");
    std::string old_login;
    std::string name;
    tx.sql() << "SELECT login, name FROM account WHERE id = :id", into(old_login), into(name),
        use(account_id, "id");
    const std::string login = "erased-" + std::to_string(account_id);
    RenameInLog(tx, old_login, name, login);
    tx.sql() << "UPDATE account SET login = :login, name = '', password_hash = '', disabled = 1, "
                "version = version + 1 WHERE id = :id",
        use(login, "login"), use(account_id, "id");
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "INSERT INTO audit_log (at_ms, actor, verb, object, detail) "
                "VALUES (:at, 'system', 'erase_account', :object, '')",
        use(now_ms, "at"), use(owner, "object");
    return Done{};
  });
}

}  // namespace faultlab::server::lab
