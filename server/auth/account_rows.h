#pragma once

#include <soci/soci.h>

#include <optional>
#include <string>

#include "server/auth/accounts.h"

// Rows of the account table and of the audit log, shared by the .cc files of Accounts.
namespace faultlab::server::account_rows {

inline constexpr const char* kColumns =
    "id, login, name, role, password_hash, disabled, created_ms, version";

struct Row {
  Account account;
  std::string role;
  std::string password_hash;
  std::int64_t disabled = 0;
  std::int64_t created_ms = 0;

  Account ToAccount() const {
    Account out = account;
    out.role = ParseRole(role).value_or(Role::kStudent);
    out.disabled = disabled != 0;
    out.has_password = !password_hash.empty();
    out.created_at = FromMilliseconds(created_ms);
    return out;
  }
};

/// One account by a condition with one parameter `:value`.
template <typename Value>
std::optional<Row> Find(Transaction& tx, const std::string& condition, const Value& value) {
  Row row;
  tx.sql() << std::string("SELECT ") + kColumns + " FROM account WHERE " + condition,
      soci::into(row.account.id), soci::into(row.account.login), soci::into(row.account.name),
      soci::into(row.role), soci::into(row.password_hash), soci::into(row.disabled),
      soci::into(row.created_ms), soci::into(row.account.version), soci::use(value, "value");
  if (!tx.sql().got_data()) return std::nullopt;
  return row;
}

inline void PutAuditLine(Transaction& tx,
                         const std::string& actor,
                         const std::string& verb,
                         const std::string& object,
                         const std::string& detail,
                         WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  tx.sql() << "INSERT INTO audit_log (at_ms, actor, verb, object, detail) "
              "VALUES (:at, :actor, :verb, :object, :detail)",
      soci::use(now_ms, "at"), soci::use(actor, "actor"), soci::use(verb, "verb"),
      soci::use(object, "object"), soci::use(detail, "detail");
}

inline core::Error NoAccount() {
  return {core::ErrorCode::kNotFound, "there is no such account", "", "no_account"};
}

}  // namespace faultlab::server::account_rows
