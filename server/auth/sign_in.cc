// Accounts: proving who one is.
#include <algorithm>

#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

constexpr auto kSignInLives = std::chrono::hours(12);
constexpr auto kLinkLives = std::chrono::hours(24);
constexpr std::size_t kPasswordMin = 10;
constexpr std::size_t kPasswordMax = 1024;

Error WrongCredentials() {
  return {ErrorCode::kUnauthorized, "login or password is wrong", ""};
}

Error SignInAgain() {
  return {ErrorCode::kUnauthorized, "your sign-in has ended; sign in again", ""};
}

std::string_view CookieValue(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(';'), header.size());
    std::string_view pair = header.substr(0, end);
    header.remove_prefix(std::min(end + 1, header.size()));
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=') {
      return pair.substr(name.size() + 1);
    }
  }
  return {};
}

/// "https://lab.example:8443" is of host "lab.example:8443".
bool OriginIsHost(std::string_view origin, std::string_view host) {
  const std::size_t scheme = origin.find("://");
  return scheme != std::string_view::npos && origin.substr(scheme + 3) == host;
}

bool IsLoopback(std::string_view address) {
  return address.starts_with("127.") || address == "::1" || address == "::ffff:127.0.0.1";
}

Principal ToPrincipal(const Account& account) {
  Principal principal;
  principal.user_id = account.id;
  principal.login = account.login;
  principal.name = account.name;
  principal.role = account.role;
  return principal;
}

std::set<std::string> SplitScopes(const std::string& text) {
  std::set<std::string> scopes;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    if (end > at) scopes.insert(text.substr(at, end - at));
    at = end + 1;
  }
  return scopes;
}

}  // namespace

core::Status CheckPasswordRules(std::string_view password) {
  if (password.size() < kPasswordMin) {
    return Error{ErrorCode::kInvalid, "a password has at least 10 characters", "password"};
  }
  if (password.size() > kPasswordMax) {
    return Error{ErrorCode::kInvalid, "a password has at most 1024 bytes", "password"};
  }
  return Done{};
}

Accounts::Accounts(Database& database, GuestAccess guests) : database_(database), guests_(guests) {}

core::Result<Principal> Accounts::Authenticate(const RequestCredentials& credentials,
                                               WallTime now) {
  constexpr std::string_view kBearer = "Bearer ";
  if (!credentials.authorization.empty()) {
    if (!credentials.authorization.starts_with(kBearer)) {
      return Error{ErrorCode::kUnauthorized, "use Authorization: Bearer <api key>", ""};
    }
    return ByKey(credentials.authorization.substr(kBearer.size()), now);
  }
  const std::string_view secret = CookieValue(credentials.cookie, kSessionCookieName);
  if (!secret.empty()) return BySession(secret, credentials, now);
  const bool near = IsLoopback(credentials.remote_address);
  if (guests_ == GuestAccess::kEverywhere || (guests_ == GuestAccess::kLoopback && near)) {
    return Principal{};
  }
  return Error{ErrorCode::kUnauthorized, "sign in first", ""};
}

core::Result<Principal> Accounts::BySession(std::string_view secret,
                                            const RequestCredentials& credentials,
                                            WallTime now) {
  const std::string hash = HashSecret(secret);
  auto found = database_.Read([&](Transaction& tx) -> core::Result<Principal> {
    std::int64_t account_id = 0;
    std::int64_t expires_ms = 0;
    std::string csrf;
    tx.sql() << "SELECT account_id, expires_ms, csrf FROM sign_in WHERE token_hash = :hash",
        into(account_id), into(expires_ms), into(csrf), use(hash, "hash");
    if (!tx.sql().got_data() || ToMilliseconds(now) >= expires_ms) return SignInAgain();
    const auto row = account_rows::Find(tx, "id = :value", account_id);
    if (!row || row->disabled != 0) return SignInAgain();
    Principal principal = ToPrincipal(row->ToAccount());
    principal.proof = Proof::kSessionCookie;
    principal.csrf_token = csrf;
    principal.session_token_hash = hash;
    return principal;
  });
  if (!found.ok() || !credentials.changes_state) return found;
  const bool foreign_origin =
      !credentials.origin.empty() && !OriginIsHost(credentials.origin, credentials.host);
  if (foreign_origin || !SameSecret(credentials.csrf_token, found.value().csrf_token)) {
    return Error{ErrorCode::kForbidden,
                 "the request does not come from this page: send X-CSRF-Token of auth/me",
                 ""};
  }
  return found;
}

core::Result<Principal> Accounts::ByKey(std::string_view secret, WallTime now) {
  const std::string hash = HashSecret(secret);
  return database_.Read([&](Transaction& tx) -> core::Result<Principal> {
    const Error refused{
        ErrorCode::kUnauthorized, "this API key is unknown, expired or revoked", ""};
    std::int64_t id = 0;
    std::int64_t account_id = 0;
    std::int64_t expires_ms = 0;
    std::int64_t revoked = 0;
    std::string scopes;
    tx.sql() << "SELECT id, account_id, expires_ms, revoked, scopes FROM api_key "
                "WHERE key_hash = :hash",
        into(id), into(account_id), into(expires_ms), into(revoked), into(scopes),
        use(hash, "hash");
    if (!tx.sql().got_data() || revoked != 0 || ToMilliseconds(now) >= expires_ms) return refused;
    const auto row = account_rows::Find(tx, "id = :value", account_id);
    if (!row || row->disabled != 0) return refused;
    Principal principal = ToPrincipal(row->ToAccount());
    principal.role = Role::kService;
    principal.proof = Proof::kApiKey;
    principal.api_key_id = id;
    principal.scopes = SplitScopes(scopes);
    return principal;
  });
}

core::Result<bool> Accounts::Holds(const Principal& who, WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  return database_.Read([&](Transaction& tx) -> core::Result<bool> {
    std::int64_t found = 0;
    if (who.proof == Proof::kApiKey) {
      tx.sql() << "SELECT COUNT(*) FROM api_key k JOIN account a ON a.id = k.account_id "
                  "WHERE k.id = :key AND k.revoked = 0 AND k.expires_ms > :now AND a.disabled = 0",
          into(found), use(who.api_key_id, "key"), use(now_ms, "now");
    } else {
      tx.sql() << "SELECT COUNT(*) FROM sign_in s JOIN account a ON a.id = s.account_id "
                  "WHERE s.token_hash = :hash AND s.expires_ms > :now AND a.disabled = 0",
          into(found), use(who.session_token_hash, "hash"), use(now_ms, "now");
    }
    return found > 0;
  });
}

core::Result<SignedIn> Accounts::SignIn(const std::string& login,
                                        const std::string& password,
                                        const std::string& address,
                                        WallTime now) {
  const auto normal = NormalLogin(login);
  const std::string name = normal.ok() ? normal.value() : "?";
  for (const core::Status& status :
       {by_account_.Check(name, now), by_address_.Check(address, now)}) {
    if (!status.ok()) return status.error();
  }
  if (password.size() > kPasswordMax) return WrongCredentials();
  using MaybeRow = std::optional<account_rows::Row>;
  const auto row = database_.Read([&](Transaction& tx) -> core::Result<MaybeRow> {
    return account_rows::Find(tx, "login = :value", name);
  });
  if (!row.ok()) return row.error();
  const bool usable = row.value().has_value() && row.value()->disabled == 0;
  const auto right = hasher_.Verify(usable ? row.value()->password_hash : "", password);
  if (!right.ok()) return right.error();
  if (!right.value()) {
    by_account_.Failed(name, now);
    by_address_.Failed(address, now);
    return WrongCredentials();
  }
  by_account_.Succeeded(name);
  SignedIn out;
  out.cookie_secret = NewSecret("fls_");
  out.principal = ToPrincipal(row.value()->ToAccount());
  out.principal.proof = Proof::kSessionCookie;
  out.principal.csrf_token = NewSecret("");
  out.principal.session_token_hash = HashSecret(out.cookie_secret);
  const auto stored = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const std::int64_t now_ms = ToMilliseconds(now);
    const std::int64_t expires_ms = ToMilliseconds(now + kSignInLives);
    tx.sql() << "DELETE FROM sign_in WHERE expires_ms < :now", use(now_ms, "now");
    tx.sql() << "INSERT INTO sign_in (token_hash, account_id, csrf, created_ms, expires_ms, "
                "address) VALUES (:hash, :account, :csrf, :now, :expires, :address)",
        use(out.principal.session_token_hash, "hash"), use(out.principal.user_id, "account"),
        use(out.principal.csrf_token, "csrf"), use(now_ms, "now"), use(expires_ms, "expires"),
        use(address, "address");
    return Done{};
  });
  if (!stored.ok()) return stored.error();
  return out;
}

core::Status Accounts::SignOut(const Principal& who) {
  const auto ended = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << "DELETE FROM sign_in WHERE token_hash = :hash", use(who.session_token_hash, "hash");
    return Done{};
  });
  if (ended.ok()) {
    Tell({.what = Revocation::What::kSignIn,
          .account_id = who.user_id,
          .sign_in = who.session_token_hash});
  }
  return ended;
}

core::Status Accounts::ChangePassword(const Principal& who,
                                      const std::string& old_password,
                                      const std::string& new_password,
                                      WallTime now) {
  if (const auto rules = CheckPasswordRules(new_password); !rules.ok()) return rules;
  const std::string throttled = "password:" + who.login;
  if (const auto status = by_account_.Check(throttled, now); !status.ok()) return status;
  const auto row = database_.Read([&](Transaction& tx) -> core::Result<account_rows::Row> {
    const auto found = account_rows::Find(tx, "id = :value", who.user_id);
    if (!found) return account_rows::NoAccount();
    return *found;
  });
  if (!row.ok()) return row.error();
  const auto right = hasher_.Verify(row.value().password_hash, old_password);
  if (!right.ok()) return right.error();
  if (!right.value()) {
    by_account_.Failed(throttled, now);
    return Error{ErrorCode::kForbidden, "the old password is wrong", "old"};
  }
  const auto hash = hasher_.Hash(new_password);
  if (!hash.ok()) return hash.error();
  const auto changed = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << "UPDATE account SET password_hash = :hash WHERE id = :id",
        use(hash.value(), "hash"), use(who.user_id, "id");
    tx.sql() << "DELETE FROM sign_in WHERE account_id = :id AND token_hash <> :this",
        use(who.user_id, "id"), use(who.session_token_hash, "this");
    return Done{};
  });
  if (changed.ok()) {
    Tell({.what = Revocation::What::kOtherSignIns,
          .account_id = who.user_id,
          .sign_in = who.session_token_hash});
  }
  return changed;
}

core::Result<std::string> Accounts::CreateLink(std::int64_t account_id, WallTime now) {
  const std::string secret = NewSecret("fll_");
  const std::string hash = HashSecret(secret);
  const std::int64_t expires_ms = ToMilliseconds(now + kLinkLives);
  const auto stored = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!account_rows::Find(tx, "id = :value", account_id)) return account_rows::NoAccount();
    tx.sql() << "DELETE FROM one_time_link WHERE account_id = :id", use(account_id, "id");
    tx.sql() << "INSERT INTO one_time_link (token_hash, account_id, expires_ms, used) "
                "VALUES (:hash, :id, :expires, 0)",
        use(hash, "hash"), use(account_id, "id"), use(expires_ms, "expires");
    return Done{};
  });
  if (!stored.ok()) return stored.error();
  return secret;
}

core::Status Accounts::UseLink(const std::string& secret,
                               const std::string& new_password,
                               WallTime now) {
  if (const auto rules = CheckPasswordRules(new_password); !rules.ok()) return rules;
  const std::string hash = HashSecret(secret);
  const Error refused{ErrorCode::kForbidden, "this link is unknown, used or expired", "token"};
  const std::int64_t now_ms = ToMilliseconds(now);
  const auto known = database_.Read([&](Transaction& tx) -> core::Status {
    std::int64_t count = 0;
    tx.sql() << "SELECT COUNT(*) FROM one_time_link WHERE token_hash = :hash AND used = 0 "
                "AND expires_ms > :now",
        into(count), use(hash, "hash"), use(now_ms, "now");
    if (count == 0) return refused;
    return Done{};
  });
  if (!known.ok()) return known;  // nobody makes us compute argon2id with a made-up link
  const auto password_hash = hasher_.Hash(new_password);
  if (!password_hash.ok()) return password_hash.error();
  std::int64_t account_id = 0;
  const auto set = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    soci::statement taken =
        (tx.sql().prepare << "UPDATE one_time_link SET used = 1 WHERE token_hash = :hash "
                             "AND used = 0 AND expires_ms > :now",
         use(hash, "hash"),
         use(now_ms, "now"));
    taken.execute(true);
    if (taken.get_affected_rows() != 1) return refused;
    tx.sql() << "SELECT account_id FROM one_time_link WHERE token_hash = :hash", into(account_id),
        use(hash, "hash");
    tx.sql() << "UPDATE account SET password_hash = :password WHERE id = :id",
        use(password_hash.value(), "password"), use(account_id, "id");
    tx.sql() << "DELETE FROM sign_in WHERE account_id = :id", use(account_id, "id");
    return Done{};
  });
  if (set.ok()) Tell({.account_id = account_id});
  return set;
}

core::Result<std::optional<std::string>> Accounts::FirstStartLink(WallTime now) {
  std::int64_t admins = 0;
  const auto counted = database_.Read([&](Transaction& tx) -> core::Status {
    tx.sql() << "SELECT COUNT(*) FROM account WHERE role = 'admin' AND password_hash <> '' "
                "AND disabled = 0",
        into(admins);
    return Done{};
  });
  if (!counted.ok()) return counted.error();
  if (admins > 0) return std::optional<std::string>{};
  auto account = GetByLogin("admin");
  if (!account.ok() && account.error().code == ErrorCode::kNotFound) {
    account = Create("admin", "Administrator", Role::kAdmin, now);
  }
  if (!account.ok()) return account.error();
  auto link = CreateLink(account.value().id, now);
  if (!link.ok()) return link.error();
  return std::optional<std::string>{link.value()};
}

}  // namespace faultlab::server
