// What was done by whom.
#include <algorithm>
#include <map>

#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/search_text.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {
namespace {

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

/// The accounts of "user:7, user:8"; none of another text, also where a person wrote it so.
std::vector<std::int64_t> AccountsIn(const AuditEntry& entry) {
  constexpr std::string_view kBetween = ", ";
  std::vector<std::int64_t> accounts;
  if (kVerbsOfLists.find("'" + entry.verb + "'") == std::string_view::npos) return accounts;
  std::string_view detail = entry.detail;
  while (true) {
    const std::size_t end = std::min(detail.find(kBetween), detail.size());
    const auto account = AccountOfOwner(detail.substr(0, end));
    if (!account) return {};
    accounts.push_back(*account);
    if (end == detail.size()) return accounts;
    detail.remove_prefix(end + kBetween.size());
  }
}

/// The log names accounts by their ids, so that nobody has to be taken out of it.
void ShowLogins(Transaction& tx, std::vector<AuditEntry>& entries) {
  std::map<std::int64_t, std::string> logins;
  std::string ids = "-1";
  for (const AuditEntry& entry : entries) {
    for (const std::int64_t id : AccountsIn(entry)) {
      if (logins.emplace(id, "").second) ids += ", " + std::to_string(id);
    }
  }
  if (logins.empty()) return;
  for (const auto& row : SelectRows<account_rows::Row>(tx, "account WHERE id IN (" + ids + ")")) {
    logins[row.account.id] = row.account.login;
  }
  for (AuditEntry& entry : entries) {
    std::string shown;
    for (const std::int64_t id : AccountsIn(entry)) {
      const std::string& login = logins.at(id);
      shown += (shown.empty() ? "" : ", ") + (login.empty() ? OwnerKeyOf(id) : login);
    }
    if (!shown.empty()) entry.detail = std::move(shown);
  }
}

}  // namespace

template <typename Visit>
void Fields(AuditEntry& entry, Visit&& visit) {
  static const std::string kName = "COALESCE(" + std::string(kObjectName) + ", '')";
  visit("seq", entry.seq);
  visit("at_ms", entry.at);
  visit("actor", entry.actor);
  visit("COALESCE(doer.login, '')", entry.actor_login);
  visit("verb", entry.verb);
  visit("object", entry.object);
  visit("COALESCE(target.login, '')", entry.object_login);
  visit(kName.c_str(), entry.object_name);
  visit("detail", entry.detail);
}

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
    Condition which;
    if (before > 0) which.And("seq < :before", {{"before", before}});
    if (filter.from) which.And("at_ms >= :from", {{"from", *filter.from}});
    if (filter.to) which.And("at_ms < :to", {{"to", *filter.to}});
    if (!filter.text.empty() || !filter.verbs.empty()) {
      Parameters parameters;
      std::string either = "1 = 0";
      if (!filter.text.empty()) {
        either =
            "LOWER(verb || ' ' || object || ' ' || detail || ' ' || COALESCE(doer.login, "
            "actor) || ' ' || COALESCE(target.login, '') || ' ' || COALESCE(" +
            std::string(kObjectName) + ", '')) LIKE LOWER(:text) ESCAPE '!' OR doer.id IN (" +
            named + ") OR target.id IN (" + named + ") OR (verb IN (" + std::string(kVerbsOfLists) +
            ") AND EXISTS (SELECT 1 FROM account "
            "listed WHERE (LOWER(listed.login) LIKE LOWER(:text) ESCAPE '!' OR listed.id IN (" +
            named + ")) AND ', ' || detail || ',' LIKE '% user:' || listed.id || ',%'))";
        parameters.emplace_back("text", ContainsPattern(filter.text));
      }
      for (const std::string& verb : filter.verbs) {
        const std::string name = "verb" + std::to_string(parameters.size());
        either += " OR verb = :" + name;
        parameters.emplace_back(name, verb);
      }
      which.And("(" + either + ")", parameters);
    }
    if (!filter.who.empty()) {
      which.And("(LOWER(COALESCE(doer.login, actor)) LIKE LOWER(:who) ESCAPE '!' OR doer.id IN (" +
                    doers + "))",
                {{"who", ContainsPattern(filter.who)}});
    }
    auto entries = SelectRows<AuditEntry>(
        tx,
        "audit_log LEFT JOIN account doer ON doer.id = CASE WHEN actor LIKE 'user:%' "
        "THEN CAST(SUBSTR(actor, 6) AS BIGINT) END "
        "LEFT JOIN account target ON target.id = CASE WHEN object LIKE "
        "'user:%' THEN CAST(SUBSTR(object, 6) AS BIGINT) WHEN object LIKE 'run:%' AND "
        "detail LIKE 'of user:%' AND detail NOT LIKE '%;%' THEN CAST(SUBSTR(detail, 9) AS BIGINT) "
        "END WHERE " +
            which.sql + " ORDER BY seq DESC LIMIT " + std::to_string(limit),
        which.parameters);
    ShowLogins(tx, entries);
    return entries;
  });
}

}  // namespace faultlab::server
