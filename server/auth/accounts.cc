// Users and their API keys.
#include "server/auth/accounts.h"

#include <algorithm>

#include "server/auth/account_rows.h"
#include "server/auth/credentials.h"
#include "server/auth/person_name.h"
#include "server/auth/search_text.h"
#include "server/storage/erased_login.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {
namespace {

using core::Done;

constexpr std::size_t kNameBytesMax = 200;
constexpr auto kKeyLivesMax = std::chrono::hours(24 * 400);
constexpr const char* kKeyIsOver = "(revoked = 1 OR expires_ms <= :now)";

/// Expired and revoked keys are kept for information, but only a limited number.
void DropPastKeys(Transaction& tx, std::int64_t account, WallTime now) {
  Execute(tx,
          std::string("DELETE FROM api_key WHERE account_id = :account AND ") + kKeyIsOver +
              " AND id NOT IN (SELECT id FROM api_key WHERE account_id = :account AND " +
              kKeyIsOver + " ORDER BY id DESC LIMIT :kept)",
          {{"account", account}, {"now", now}, {"kept", Accounts::kPastKeysKept}});
}

core::Status CheckLiveKeys(Transaction& tx, std::int64_t account, WallTime now) {
  const std::int64_t live =
      CountRows(tx,
                std::string("api_key WHERE account_id = :account AND NOT ") + kKeyIsOver,
                {{"account", account}, {"now", now}});
  if (live < Accounts::kLiveKeysMax) return Done{};
  return core::Refuse("keys_full", "", {{"most", Accounts::kLiveKeysMax}});
}

core::Status CheckName(const std::string& name) {
  if (name.empty() || name.size() > kNameBytesMax) {
    return core::Refuse("name_length", "name");
  }
  return Done{};
}

}  // namespace

core::Result<std::string> NormalLogin(std::string_view login) {
  std::string out(login);
  std::ranges::transform(out, out.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  const bool plain =
      out.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789._@-") == std::string::npos;
  if (out.size() < 3 || out.size() > 64 || !plain || out.starts_with(kErasedLogin)) {
    return core::Refuse("login_wrong", "login");
  }
  return out;
}

core::Result<Account> Accounts::Create(const std::string& login,
                                       const std::string& wanted_name,
                                       Role role,
                                       WallTime now) {
  TRY(const auto normal, NormalLogin(login));
  const std::string name = CleanName(wanted_name);
  if (const auto good = CheckName(name); !good.ok()) return good.error();
  if (role == Role::kGuest || role == Role::kService) {
    return core::Refuse("word_unknown",
                        "role",
                        {{"member", "role"}, {"words", "student, instructor, operator, admin"}});
  }
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Account> {
    if (account_rows::Find(tx, "login = :value", normal)) {
      return core::Refuse("login_taken", "login");
    }
    return account_rows::Add(tx, normal, name, role, now);
  });
}

core::Result<Account> Accounts::Change(std::int64_t id,
                                       std::int64_t version,
                                       const std::optional<std::string>& name,
                                       std::optional<Role> role,
                                       std::optional<bool> disabled) {
  const std::string clean = CleanName(name.value_or(""));
  if (name) {
    if (const auto good = CheckName(clean); !good.ok()) return good.error();
  }
  bool fewer_rights = false;
  const auto write = [&](Transaction& tx) -> core::Result<Account> {
    const auto row = account_rows::Find(tx, "id = :value", id);
    if (!row) return account_rows::NoAccount();
    const Account before = row->ToAccount();
    const std::string& new_name = name ? clean : before.name;
    const bool new_disabled = disabled.value_or(before.disabled);
    if (Execute(tx,
                "UPDATE account SET name = :name, role = :role, "
                "disabled = :disabled, version = version + 1 "
                "WHERE id = :id AND version = :version",
                {{"name", new_name},
                 {"role", Name(role.value_or(before.role))},
                 {"disabled", new_disabled},
                 {"id", id},
                 {"version", version}}) != 1) {
      return core::Refuse("account_changed");
    }
    if (new_disabled) credentials::EndAll(tx, id);
    const Account after = account_rows::Find(tx, "id = :value", id)->ToAccount();
    fewer_rights = after.disabled || after.role != before.role;
    return after;
  };
  auto changed = database_.Write(Durability::kPromise, write);
  if (changed.ok() && fewer_rights) Tell({.account_id = id});
  return changed;
}

core::Result<Account> Accounts::Get(std::int64_t id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Account> {
    const auto row = account_rows::Find(tx, "id = :value", id);
    if (!row) return account_rows::NoAccount();
    return row->ToAccount();
  });
}

core::Result<Account> Accounts::GetByLogin(const std::string& login) {
  TRY(const auto normal, NormalLogin(login));
  return database_.Read([&](Transaction& tx) -> core::Result<Account> {
    const auto row = account_rows::Find(tx, "login = :value", normal);
    if (!row) return account_rows::NoAccount();
    return row->ToAccount();
  });
}

core::Result<std::vector<Account>> Accounts::List(const AccountFilter& filter,
                                                  std::int64_t after,
                                                  int limit) {
  using Found = std::vector<Account>;
  const std::string wanted = FoldLetters(filter.text);
  return database_.Read([&](Transaction& tx) -> core::Result<Found> {
    std::string from = "account WHERE id > " + std::to_string(after);
    if (filter.role) from += " AND role = '" + std::string(Name(*filter.role)) + "'";
    if (filter.course) {
      from += " AND id IN (SELECT account_id FROM enrolment WHERE course_id = " +
              std::to_string(*filter.course) + ")";
    }
    Found out;
    // Compared here: SQLite knows the case of ASCII letters only, and names are in any script.
    const auto add = [&](const account_rows::Row& row) {
      const std::string text = FoldLetters(row.account.login + " " + row.account.name);
      if (text.find(wanted) != std::string::npos) out.push_back(row.ToAccount());
      return std::ssize(out) < limit;
    };
    ForEachRow<account_rows::Row>(tx, from + " ORDER BY id", add);
    return out;
  });
}

core::Result<Accounts::NewKey> Accounts::CreateKey(const Principal& who,
                                                   const std::string& name,
                                                   const std::set<std::string>& scopes,
                                                   WallTime expires_at,
                                                   WallTime now) {
  if (const auto good = CheckName(name); !good.ok()) return good.error();
  if (scopes.empty()) return core::Refuse("scopes_missing", "scopes");
  for (const auto& scope : scopes) {
    if (std::ranges::find(kScopes, scope) == kScopes.end()) {
      return core::Refuse("scope_unknown", "scopes", {{"scope", scope}});
    }
    if (!MayHaveScope(who.role, scope)) {
      return core::Refuse("scope_of_others", "scopes", {{"scope", scope}});
    }
  }
  if (expires_at <= now || expires_at > now + kKeyLivesMax) {
    return core::Refuse("key_lifetime", "expires_at");
  }
  NewKey out;
  out.secret = NewSecret("flk_");
  out.key = {0, who.user_id, name, scopes, now, expires_at, false};
  TRY_DONE(database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TakeTurn(tx, "keys of " + std::to_string(who.user_id));
    DropPastKeys(tx, who.user_id, now);
    TRY_DONE(CheckLiveKeys(tx, who.user_id, now));
    out.key.id = AddInto(tx,
                         "api_key",
                         {{"account_id", who.user_id},
                          {"name", name},
                          {"key_hash", HashSecret(out.secret)},
                          {"scopes", account_rows::ScopesText::Write(scopes)},
                          {"created_ms", now},
                          {"expires_ms", expires_at},
                          {"revoked", 0}});
    return Done{};
  }));
  return out;
}

core::Result<std::vector<ApiKey>> Accounts::ListKeys(std::int64_t account_id, WallTime now) {
  return database_.Read([&](Transaction& tx) {
    auto out = SelectRows<ApiKey>(tx,
                                  std::string("api_key WHERE account_id = :account ORDER BY CASE "
                                              "WHEN ") +
                                      kKeyIsOver + " THEN 1 ELSE 0 END, id DESC LIMIT " +
                                      std::to_string(kKeysShownMax),
                                  {{"account", account_id}, {"now", now}});
    std::ranges::sort(out, {}, &ApiKey::id);
    return out;
  });
}

core::Status Accounts::RevokeKey(std::int64_t account_id, std::int64_t key_id, WallTime now) {
  const auto revoked = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (UpdateWhere(
            tx, "api_key", {{"revoked", 1}}, {{"id", key_id}, {"account_id", account_id}}) != 1) {
      return core::Refuse("no_api_key");
    }
    DropPastKeys(tx, account_id, now);
    return Done{};
  });
  if (revoked.ok()) {
    Tell({.what = Revocation::What::kApiKey, .account_id = account_id, .api_key_id = key_id});
  }
  return revoked;
}

}  // namespace faultlab::server
