#include "server/privacy/person_data.h"

#include <soci/soci.h>

#include <array>
#include <map>
#include <string_view>
#include <utility>

#include "core/types/number_text.h"
#include "server/storage/erased_login.h"
#include "server/storage/owner_key.h"
#include "server/storage/picture_store.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

/// A table that contains data of a person. `columns` and `condition` may contain :id, the number of
/// the account, :owner, its key "user:7", and :lists, kVerbsOfLists.
struct Place {
  const char* table;
  const char* columns;
  const char* condition;
};

constexpr std::array kPlaces = {
    Place{"account", "id, login, name, role, disabled, created_ms", "id = :id"},
    Place{"sign_in", "created_ms, expires_ms, address", "account_id = :id"},
    Place{"known_device", "created_ms, used_ms, network", "account_id = :id"},
    Place{"external_identity", "issuer, subject, created_ms", "account_id = :id"},
    Place{"lti_seat", "platform_id, assignment_id, subject, lineitem", "account_id = :id"},
    Place{"api_key", "id, name, scopes, created_ms, expires_ms, revoked", "account_id = :id"},
    Place{"one_time_link", "expires_ms, used", "account_id = :id"},
    Place{"calendar_link", "created_ms", "account_id = :id"},
    Place{"enrolment", "course_id, teaches", "account_id = :id"},
    Place{"course_invitation", "course_id, invited_by, created_ms", "account_id = :id"},
    Place{"recording",
          "id, name, note, rig, source, state, created_ms, ended_ms, samples, period_s, plan_json, "
          "diagnosis_json",
          "owner = :owner"},
    Place{"recording_picture",
          "recording_id, picture, sample_index, why, content_type, size_bytes",
          "recording_id IN (SELECT id FROM recording WHERE owner = :owner)"},
    Place{"recording_star", "recording_id", "who = :owner"},
    Place{"job", "id, name, state, body, result, error, created_ms, ended_ms", "owner = :owner"},
    Place{"fault_set", "id, course_id, name, faults, created_ms", "account_id = :id"},
    Place{"assignment", "id, course_id, name, opens_ms, due_ms", "account_id = :id"},
    // What is not released stays sealed in the export of its student too.
    Place{"trial",
          "id, assignment_id, state, run, commitment, created_ms, answered_ms, answer, hints, "
          "CASE WHEN released_ms > 0 THEN truth ELSE '' END AS truth, "
          "CASE WHEN released_ms > 0 THEN grade ELSE '' END AS grade, awarded",
          "account_id = :id"},
    Place{"assignment_extension", "assignment_id, due_ms", "account_id = :id"},
    Place{"assignment_mate", "assignment_id, group_id", "account_id = :id"},
    Place{"remembered_answer", "idempotency_key, status, body, at_ms", "owner = :owner"},
    Place{"lab_ticket", "id, rig_class, created_ms, state, courses", "user_id = :id"},
    Place{"lab_booking",
          "id, rig_class, rig, start_ms, end_ms, state, note, courses",
          "user_id = :id"},
    Place{
        "lab_session", "id, rig, start_ms, hard_end_ms, state, end_text, courses", "user_id = :id"},
    Place{"lab_usage", "seconds, at_ms, week, this_week_ms", "user_id = :id"},
    Place{"lab_event", "at_ms, topic, text, rig, why, reason, time_ms", "user_id = :id"},
    Place{"mail_choice", "address, language, kinds, asked_ms, verified_ms", "account_id = :id"},
    Place{"webhook", "id, url, kinds, created_ms", "account_id = :id"},
    Place{"ended", "kind, subject", "account_id = :id"},
    Place{"outbox", "channel, kind, about, created_ms, state", "account_id = :id"},
    Place{"alarm", "kind, subject, acked_ms", "acked_by = :id"},
    // Of a list that others wrote, without the other people.
    Place{"audit_log",
          "at_ms, actor, verb, object, CASE WHEN actor <> :owner AND verb IN (:lists) THEN :owner "
          "ELSE detail END AS detail",
          "actor = :owner OR object = :owner OR (object LIKE 'run:%' AND detail = 'of ' || :owner) "
          "OR (verb IN (:lists) AND ', ' || detail || ',' LIKE '% ' || :owner || ',%')"},
};

std::string Text(const soci::row& row, std::size_t at) {
  if (row.get_indicator(at) == soci::i_null) return "";
  switch (row.get_properties(at).get_data_type()) {
    case soci::dt_string:
      return row.get<std::string>(at);
    case soci::dt_double:
      return core::Shortest(row.get<double>(at));
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

/// A condition uses one parameter several times, but SOCI binds parameters by place, so the values
/// are inserted as text.
std::string Bound(std::string condition, std::int64_t id, const std::string& owner) {
  const std::string number = std::to_string(id);
  const std::string quoted = "'" + owner + "'";  // safe to insert: built here from a number
  for (const auto& [word, by] : {std::pair{std::string(":id"), number},
                                 std::pair{std::string(":owner"), quoted},
                                 std::pair{std::string(":lists"), std::string(kVerbsOfLists)}}) {
    for (std::size_t at = condition.find(word); at != std::string::npos;
         at = condition.find(word, at + by.size())) {
      condition.replace(at, word.size(), by);
    }
  }
  return condition;
}

PersonTable Read(Transaction& tx, const Place& place, std::int64_t account_id) {
  PersonTable table{place.table, {}, {}};
  const auto bound = [&](const char* text) {
    return Bound(text, account_id, OwnerKeyOf(account_id));
  };
  const std::string query = "SELECT " + bound(place.columns) + " FROM " + place.table + " WHERE " +
                            bound(place.condition) + " ORDER BY 1";
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

/// What has to end before the person can be erased.
core::Status CheckAtRest(Transaction& tx, std::int64_t account_id) {
  struct Living {
    const char* what;
    const char* from;
  };
  constexpr std::array kLiving = {
      Living{"a run in progress",
             "recording WHERE owner = :owner AND state = 'running' AND source <> 'upload'"},
      Living{"a session", "lab_session WHERE user_id = :id AND state < 2"},
      Living{"a place in a queue", "lab_ticket WHERE user_id = :id AND state < 2"},
      Living{"a booking", "lab_booking WHERE user_id = :id AND state IN (0, 7)"},
      Living{"a job", "job WHERE owner = :owner AND state IN ('waiting', 'running')"}};
  for (const Living& living : kLiving) {
    const std::int64_t count =
        CountRows(tx, Bound(living.from, account_id, OwnerKeyOf(account_id)));
    if (count == 0) continue;
    return Error{ErrorCode::kConflict,
                 std::string("this account has ") + living.what + "; end it first",
                 "",
                 "internal"};
  }
  return Done{};
}

/// The id of the recording that a plan replays.
std::string ReplayedBy(const std::string& plan_json) {
  constexpr std::string_view kMember = "\"recording\":\"";
  const std::size_t at = plan_json.find(kMember);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + kMember.size();
  return plan_json.substr(begin, plan_json.find('"', begin) - begin);
}

/// A replay by another person is named after the recording, and so are replays of it; from now on
/// they are named by the recording's id.
void RenameReplays(Transaction& tx, const std::string& owner) {
  const std::string prefix = "replay of ";
  std::map<std::string, std::pair<std::string, std::string>> names;  // by id: old name, new name
  for (const auto& [id, name] : SelectTuples<std::string, std::string>(
           tx,
           "SELECT id, name FROM recording WHERE owner = :owner AND name <> ''",
           {{"owner", owner}})) {
    names[id] = {name, id};
  }
  std::vector<std::pair<std::string, std::string>> renamed;  // id, name
  for (const auto& [id, name, plan] : SelectTuples<std::string, std::string, std::string>(
           tx,
           "SELECT id, name, plan_json FROM recording WHERE owner <> :owner AND "
           "name LIKE 'replay of %' ORDER BY created_ms, id",
           {{"owner", owner}})) {
    const auto of = names.find(ReplayedBy(plan));
    if (of == names.end() || name != prefix + of->second.first) continue;
    const std::string now = prefix + of->second.second;
    names[id] = {name, now};
    renamed.emplace_back(id, now);
  }
  for (const auto& [id, name] : renamed) {
    UpdateWhere(tx, "recording", {{"name", name}}, {{"id", id}});
  }
}

std::vector<std::string> RecordingIds(Transaction& tx, const std::string& owner) {
  return SelectColumn<std::string>(
      tx, "SELECT id FROM recording WHERE owner = :owner ORDER BY created_ms", {{"owner", owner}});
}

/// What a group has done together stays with who is left of it.
void GiveToMates(Transaction& tx, std::int64_t account_id) {
  const auto shared = SelectTuples<std::int64_t, std::string, std::int64_t>(
      tx,
      "SELECT t.id, t.run, MIN(mate.account_id) FROM trial t "
      "JOIN assignment_mate own ON own.assignment_id = t.assignment_id AND "
      "own.account_id = t.account_id "
      "JOIN assignment_mate mate ON mate.group_id = own.group_id AND "
      "mate.account_id <> own.account_id "
      "JOIN account a ON a.id = mate.account_id AND a.disabled = 0 "
      "WHERE t.account_id = :id GROUP BY t.id, t.run",
      {{"id", account_id}});
  for (const auto& [trial, run, mate] : shared) {
    UpdateWhere(tx, "trial", {{"account_id", mate}}, {{"id", trial}});
    UpdateWhere(tx, "recording", {{"owner", OwnerKeyOf(mate)}, {"note", ""}}, {{"id", run}});
  }
}

/// Of accounts of older programs somebody else may have it.
std::string FreeErasedLogin(Transaction& tx, std::int64_t account_id) {
  const std::string plain = std::string(kErasedLogin) + std::to_string(account_id);
  std::string login = plain;
  for (int next = 2;; ++next) {
    if (CountRows(tx,
                  "account WHERE login = :login AND id <> :id",
                  {{"login", login}, {"id", account_id}}) == 0) {
      return login;
    }
    login = plain + "-" + std::to_string(next);
  }
}

}  // namespace

core::Result<std::vector<PersonTable>> PersonData(Database& database, std::int64_t account_id) {
  return database.Read([&](Transaction& tx) {
    std::vector<PersonTable> tables;
    for (const Place& place : kPlaces) tables.push_back(Read(tx, place, account_id));
    return tables;
  });
}

core::Result<std::vector<std::string>> RecordingsOf(Database& database, std::int64_t account_id) {
  return database.Read([&](Transaction& tx) { return RecordingIds(tx, OwnerKeyOf(account_id)); });
}

core::Status ErasePerson(Database& database, std::int64_t account_id, WallTime now) {
  return database.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TRY_DONE(CheckAtRest(tx, account_id));
    const std::string owner = OwnerKeyOf(account_id);
    GiveToMates(tx, account_id);
    RenameReplays(tx, owner);
    const std::string own = "(SELECT id FROM recording WHERE owner = '" + owner + "')";
    for (const std::string& id : RecordingIds(tx, owner)) EraseRecordingBlobs(tx, id);
    Execute(tx, "DELETE FROM recording_event WHERE recording_id IN " + own);
    DeleteFrom(tx, "recording_star", {{"who", owner}});
    for (const char* table : {"recording", "job", "remembered_answer"}) {
      DeleteFrom(tx, table, {{"owner", owner}});
    }
    for (const char* table : {"trial",
                              "assignment_extension",
                              "assignment_mate",
                              "sign_in",
                              "known_device",
                              "external_identity",
                              "lti_seat",
                              "api_key",
                              "one_time_link",
                              "calendar_link",
                              "mail_choice",
                              "webhook",
                              "ended",
                              "outbox",
                              "enrolment",
                              "course_invitation"}) {
      DeleteFrom(tx, table, {{"account_id", account_id}});
    }
    DeleteFrom(tx, "lab_event", {{"user_id", account_id}});
    for (const char* table : {"lab_ticket", "lab_booking", "lab_session"}) {
      UpdateWhere(tx, table, {{"courses", ""}}, {{"user_id", account_id}});
    }
    const std::string login = FreeErasedLogin(tx, account_id);
    Execute(tx,
            "UPDATE account SET login = :login, name = '', password_hash = '', disabled = 1, "
            "version = version + 1 WHERE id = :id",
            {{"login", login}, {"id", account_id}});
    InsertInto(tx,
               "audit_log",
               {{"at_ms", now},
                {"actor", "system"},
                {"verb", "erase_account"},
                {"object", owner},
                {"detail", ""}});
    return Done{};
  });
}

}  // namespace faultlab::server
