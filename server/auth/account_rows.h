#pragma once

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>

#include "server/auth/accounts.h"
#include "server/storage/rows.h"

// Rows of the account table and of the audit log, shared by the .cc files of Accounts.
namespace faultlab::server::account_rows {

/// Of accounts that a class list has made and nobody can sign in to yet.
inline const std::string kUnopened =
    "password_hash = '' AND disabled = 0 AND role = 'student' AND made_by <> 0 AND id NOT IN "
    "(SELECT account_id FROM external_identity)";

struct Row {
  Account account;
  std::string password_hash{};
  std::int64_t made_by = 0;  ///< the teacher whose class list it was; 0: nobody's

  Account ToAccount() const {
    Account out = account;
    out.has_password = !password_hash.empty();
    return out;
  }
};

template <typename Visit>
void Fields(Row& row, Visit&& visit) {
  visit("id", row.account.id);
  visit("login", row.account.login);
  visit("name", row.account.name);
  visit("role", row.account.role, kRoleNames);
  visit("password_hash", row.password_hash);
  visit("disabled", row.account.disabled);
  visit("created_ms", row.account.created_at);
  visit("version", row.account.version);
  visit("made_by", row.made_by);
}

/// "jobs lab". What is no scope (any more) is none.
struct ScopesText {
  static std::string Write(const std::set<std::string>& scopes) {
    std::string text;
    for (const std::string& scope : scopes) text += (text.empty() ? "" : " ") + scope;
    return text;
  }
  static std::set<std::string> Read(std::string_view text) {
    std::set<std::string> scopes;
    std::istringstream words{std::string(text)};
    for (std::string scope; words >> scope;) {
      if (std::ranges::find(kScopes, scope) != kScopes.end()) scopes.insert(scope);
    }
    return scopes;
  }
};

/// One account by a condition with one parameter `:value`.
template <typename Value>
std::optional<Row> Find(Transaction& tx, const std::string& condition, const Value& value) {
  return SelectRow<Row>(tx, "account WHERE " + condition, {{"value", value}});
}

/// A new one without a password.
inline Account Add(Transaction& tx,
                   const std::string& login,
                   const std::string& name,
                   Role role,
                   WallTime now,
                   std::int64_t made_by = 0) {
  Row row{.account = {.login = login, .name = name, .role = role, .created_at = now},
          .made_by = made_by};
  row.account.id = AddRow(tx, "account", row);
  return row.account;
}

inline void PutAuditLine(Transaction& tx,
                         const std::string& actor,
                         const std::string& verb,
                         const std::string& object,
                         const std::string& detail,
                         WallTime now) {
  InsertInto(
      tx,
      "audit_log",
      {{"at_ms", now}, {"actor", actor}, {"verb", verb}, {"object", object}, {"detail", detail}});
}

inline core::Error NoAccount() {
  return core::Refuse("no_account");
}

}  // namespace faultlab::server::account_rows

namespace faultlab::server {

template <typename Visit>
void Fields(ApiKey& key, Visit&& visit) {
  visit("id", key.id);
  visit("account_id", key.account_id);
  visit("name", key.name);
  visit("scopes", key.scopes, account_rows::ScopesText{});
  visit("created_ms", key.created_at);
  visit("expires_ms", key.expires_at);
  visit("revoked", key.revoked);
}

}  // namespace faultlab::server
