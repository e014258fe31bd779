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
using soci::into;
using soci::use;

constexpr std::size_t kNameBytesMax = 200;
constexpr auto kKeyLivesMax = std::chrono::hours(24 * 400);
constexpr const char* kKeyIsOver = "(revoked = 1 OR expires_ms <= :now)";

/// Expired and revoked keys are kept for information, but only a limited number.
void DropPastKeys(Transaction& tx, std::int64_t account, std::int64_t now_ms) {
  const int kept = Accounts::kPastKeysKept;
  tx.sql() << std::string("DELETE FROM api_key WHERE account_id = :account AND ") + kKeyIsOver +
                  " AND id NOT IN (SELECT id FROM api_key WHERE account_id = :same AND "
                  "(revoked = 1 OR expires_ms <= :then) ORDER BY id DESC LIMIT :kept)",
      use(account, "account"), use(now_ms, "now"), use(account, "same"), use(now_ms, "then"),
      use(kept, "kept");
}

core::Status CheckLiveKeys(Transaction& tx, std::int64_t account, std::int64_t now_ms) {
  std::int64_t live = 0;
  tx.sql() << std::string("SELECT COUNT(*) FROM api_key WHERE account_id = :account AND NOT ") +
                  kKeyIsOver,
      into(live), use(account, "account"), use(now_ms, "now");
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
  std::transform(out.begin(), out.end(), out.begin(), [](char c) {
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
    const std::string new_role(Name(role.value_or(before.role)));
    const std::int64_t new_disabled = disabled.value_or(before.disabled) ? 1 : 0;
    if (Execute(tx,
                "UPDATE account SET name = :name, role = :role, "
                "disabled = :disabled, version = version + 1 "
                "WHERE id = :id AND version = :version",
                use(new_name, "name"),
                use(new_role, "role"),
                use(new_disabled, "disabled"),
                use(id, "id"),
                use(version, "version")) != 1) {
      return core::Refuse("account_changed");
    }
    if (new_disabled != 0) credentials::EndAll(tx, id);
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
  std::string joined;
  for (const auto& scope : scopes) {
    if (std::find(kScopes.begin(), kScopes.end(), scope) == kScopes.end()) {
      return core::Refuse("scope_unknown", "scopes", {{"scope", scope}});
    }
    if (!MayHaveScope(who.role, scope)) {
      return core::Refuse("scope_of_others", "scopes", {{"scope", scope}});
    }
    joined += (joined.empty() ? "" : " ") + scope;
  }
  if (expires_at <= now || expires_at > now + kKeyLivesMax) {
    return core::Refuse("key_lifetime", "expires_at");
  }
  NewKey out;
  out.secret = NewSecret("flk_");
  out.key = {0, who.user_id, name, scopes, now, expires_at, false};
  const auto stored = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const std::string hash = HashSecret(out.secret);
    const std::int64_t now_ms = ToMilliseconds(now);
    const std::int64_t expires_ms = ToMilliseconds(expires_at);
    TakeTurn(tx, "keys of " + std::to_string(who.user_id));
    DropPastKeys(tx, who.user_id, now_ms);
    if (const auto room = CheckLiveKeys(tx, who.user_id, now_ms); !room.ok()) return room;
    tx.sql() << "INSERT INTO api_key (account_id, name, key_hash, scopes, created_ms, expires_ms, "
                "revoked) VALUES (:account, :name, :hash, :scopes, :now, :expires, 0) RETURNING id",
        into(out.key.id), use(who.user_id, "account"), use(name, "name"), use(hash, "hash"),
        use(joined, "scopes"), use(now_ms, "now"), use(expires_ms, "expires");
    return Done{};
  });
  if (!stored.ok()) return stored.error();
  return out;
}

core::Result<std::vector<ApiKey>> Accounts::ListKeys(std::int64_t account_id, WallTime now) {
  using Keys = std::vector<ApiKey>;
  const std::int64_t now_ms = ToMilliseconds(now);
  const int most = kKeysShownMax;
  return database_.Read([&](Transaction& tx) -> core::Result<Keys> {
    ApiKey key;
    std::string scopes;
    std::int64_t created_ms = 0;
    std::int64_t expires_ms = 0;
    std::int64_t revoked = 0;
    soci::statement statement =
        (tx.sql().prepare << std::string("SELECT id, account_id, name, scopes, created_ms, "
                                         "expires_ms, revoked FROM api_key WHERE account_id = "
                                         ":account ORDER BY CASE WHEN ") +
                                 kKeyIsOver + " THEN 1 ELSE 0 END, id DESC LIMIT :most",
         into(key.id),
         into(key.account_id),
         into(key.name),
         into(scopes),
         into(created_ms),
         into(expires_ms),
         into(revoked),
         use(account_id, "account"),
         use(now_ms, "now"),
         use(most, "most"));
    statement.execute(false);
    Keys out;
    while (statement.fetch()) {
      key.scopes.clear();
      for (const auto scope : kScopes) {
        if ((" " + scopes + " ").find(" " + std::string(scope) + " ") != std::string::npos) {
          key.scopes.insert(std::string(scope));
        }
      }
      key.created_at = FromMilliseconds(created_ms);
      key.expires_at = FromMilliseconds(expires_ms);
      key.revoked = revoked != 0;
      out.push_back(key);
    }
    std::sort(out.begin(), out.end(), [](const ApiKey& a, const ApiKey& b) { return a.id < b.id; });
    return out;
  });
}

core::Status Accounts::RevokeKey(std::int64_t account_id, std::int64_t key_id, WallTime now) {
  const auto revoked = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (Execute(tx,
                "UPDATE api_key SET revoked = 1 WHERE id = :id AND account_id = :account",
                use(key_id, "id"),
                use(account_id, "account")) != 1) {
      return core::Refuse("no_api_key");
    }
    DropPastKeys(tx, account_id, ToMilliseconds(now));
    return Done{};
  });
  if (revoked.ok()) {
    Tell({.what = Revocation::What::kApiKey, .account_id = account_id, .api_key_id = key_id});
  }
  return revoked;
}

}  // namespace faultlab::server
