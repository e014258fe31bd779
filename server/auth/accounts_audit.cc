// What was done by whom.
#include <deque>

#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/search_text.h"

namespace faultlab::server {
namespace {

using soci::into;
using soci::use;

constexpr int kPeopleOfAWordMax = 500;  ///< whose lines a search includes

/// What people call the object of a line; NULL when it has no name or is gone.
constexpr std::string_view kObjectName =
    "CASE WHEN object LIKE 'course:%' THEN "
    "(SELECT name FROM course WHERE id = CAST(SUBSTR(object, 8) AS BIGINT)) "
    "WHEN object LIKE 'fault_set:%' THEN "
    "(SELECT name FROM fault_set WHERE id = CAST(SUBSTR(object, 11) AS BIGINT)) "
    "WHEN object LIKE 'key:%' THEN "
    "(SELECT name FROM api_key WHERE id = CAST(SUBSTR(object, 5) AS BIGINT)) "
    "WHEN object LIKE 'session:%' THEN "
    "(SELECT rig FROM lab_session WHERE id = CAST(SUBSTR(object, 9) AS BIGINT)) END";

}  // namespace

core::Status Accounts::Audit(const std::string& actor,
                             const std::string& verb,
                             const std::string& object,
                             const std::string& detail,
                             WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    account_rows::PutAuditLine(tx, actor, verb, object, detail, now);
  });
}

core::Result<std::vector<AuditEntry>> Accounts::ListAudit(const AuditFilter& filter,
                                                          std::int64_t before,
                                                          int limit) {
  using Entries = std::vector<AuditEntry>;
  // Names are compared here, not by the database: List().
  const auto ids_of = [&](const std::string& text) -> core::Result<std::string> {
    std::string ids = "-1";
    if (text.empty()) return ids;
    TRY(const auto people, List({.text = text}, 0, kPeopleOfAWordMax));
    for (const Account& each : people) ids += ", " + std::to_string(each.id);
    return ids;
  };
  TRY(const auto named, ids_of(filter.text));
  TRY(const auto doers, ids_of(filter.who));
  return database_.Read([&](Transaction& tx) {
    std::string condition = "1 = 1";
    if (before > 0) condition += " AND seq < " + std::to_string(before);
    if (filter.from) condition += " AND at_ms >= " + std::to_string(ToMilliseconds(*filter.from));
    if (filter.to) condition += " AND at_ms < " + std::to_string(ToMilliseconds(*filter.to));
    AuditEntry entry;
    std::int64_t at_ms = 0;
    const std::string text = ContainsPattern(filter.text);
    const std::string who = ContainsPattern(filter.who);
    std::deque<std::string> names;
    soci::statement statement(tx.sql());  // ends before what it is bound to
    // In the order in which they stand in the query.
    if (!filter.text.empty()) statement.exchange(use(text, "text"));
    if (!filter.text.empty() || !filter.verbs.empty()) {
      std::string either = filter.text.empty()
                               ? "1 = 0"
                               : "LOWER(verb || ' ' || object || ' ' || detail || ' ' || "
                                 "COALESCE(doer.login, actor) || ' ' || COALESCE(target.login, "
                                 "'') || ' ' || COALESCE(" +
                                     std::string(kObjectName) +
                                     ", '')) LIKE LOWER(:text) ESCAPE '!' OR doer.id IN (" + named +
                                     ") OR target.id IN (" + named + ")";
      for (const std::string& verb : filter.verbs) {
        names.push_back("verb" + std::to_string(names.size()));
        either += " OR verb = :" + names.back();
        statement.exchange(use(verb, names.back()));
      }
      condition += " AND (" + either + ")";
    }
    if (!filter.who.empty()) {
      condition +=
          " AND (LOWER(COALESCE(doer.login, actor)) LIKE LOWER(:who) ESCAPE '!' OR "
          "doer.id IN (" +
          doers + "))";
      statement.exchange(use(who, "who"));
    }
    statement.exchange(into(entry.seq));
    statement.exchange(into(at_ms));
    statement.exchange(into(entry.actor));
    statement.exchange(into(entry.actor_login));
    statement.exchange(into(entry.verb));
    statement.exchange(into(entry.object));
    statement.exchange(into(entry.object_login));
    statement.exchange(into(entry.object_name));
    statement.exchange(into(entry.detail));
    statement.alloc();
    statement.prepare(
        "SELECT seq, at_ms, actor, COALESCE(doer.login, ''), verb, object, "
        "COALESCE(target.login, ''), COALESCE(" +
        std::string(kObjectName) +
        ", ''), detail FROM audit_log "
        "LEFT JOIN account doer ON doer.id = CASE WHEN actor LIKE 'user:%' "
        "THEN CAST(SUBSTR(actor, 6) AS BIGINT) END "
        "LEFT JOIN account target ON target.id = CASE WHEN object LIKE "
        "'user:%' THEN CAST(SUBSTR(object, 6) AS BIGINT) WHEN object LIKE 'run:%' AND "
        "detail LIKE 'of user:%' AND detail NOT LIKE '%;%' THEN CAST(SUBSTR(detail, 9) AS BIGINT) "
        "END WHERE " +
        condition + " ORDER BY seq DESC LIMIT " + std::to_string(limit));
    statement.define_and_bind();
    statement.execute(false);
    Entries out;
    while (statement.fetch()) {
      entry.at = FromMilliseconds(at_ms);
      out.push_back(entry);
    }
    return out;
  });
}

}  // namespace faultlab::server
