// Accounts: authentication by password.
#include <algorithm>

#include "server/address_key.h"
#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/credentials.h"
#include "server/storage/owner_key.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

Error WrongCredentials() {
  return core::Refuse("sign_in_wrong");
}

Error SignInAgain() {
  return core::Refuse("sign_in_ended");
}

/// "https://lab.example:8443" has the host "lab.example:8443".
bool OriginIsHost(std::string_view origin, std::string_view host) {
  const std::size_t scheme = origin.find("://");
  return scheme != std::string_view::npos && origin.substr(scheme + 3) == host;
}

bool IsLoopback(std::string_view address) {
  return address.starts_with("127.") || address == "::1" || address == "::ffff:127.0.0.1";
}

}  // namespace

Principal PrincipalOf(const Account& account) {
  Principal principal;
  principal.user_id = account.id;
  principal.login = account.login;
  principal.name = account.name;
  principal.role = account.role;
  return principal;
}

Accounts::Accounts(Database& database, GuestAccess guests, PasswordCost password_cost)
    : database_(database), guests_(guests), hasher_(password_cost) {}

core::Result<Principal> Accounts::Authenticate(const RequestCredentials& credentials,
                                               WallTime now) {
  constexpr std::string_view kBearer = "Bearer ";
  if (!credentials.authorization.empty()) {
    if (!credentials.authorization.starts_with(kBearer)) {
      return Error{
          ErrorCode::kUnauthorized, "use Authorization: Bearer <api key>", "", "bearer_needed"};
    }
    return ByKey(credentials.authorization.substr(kBearer.size()), now);
  }
  const std::string_view secret = CookieValue(credentials.cookie, kSessionCookieName);
  if (!secret.empty()) return BySession(secret, credentials, now);
  const bool near = IsLoopback(credentials.remote_address);
  if (guests_ == GuestAccess::kEverywhere || (guests_ == GuestAccess::kLoopback && near)) {
    return Principal{};
  }
  return core::Refuse("sign_in_first");
}

core::Result<Principal> Accounts::BySession(std::string_view secret,
                                            const RequestCredentials& credentials,
                                            WallTime now) {
  const std::string hash = HashSecret(secret);
  auto found = database_.Read([&](Transaction& tx) -> core::Result<Principal> {
    const auto kept = SelectTuple<std::int64_t, WallTime, std::string>(
        tx,
        "SELECT account_id, expires_ms, csrf FROM sign_in WHERE token_hash = :hash",
        {{"hash", hash}});
    if (!kept) return SignInAgain();
    const auto& [account_id, expires, csrf] = *kept;
    if (now >= expires) return SignInAgain();
    const auto row = account_rows::Find(tx, "id = :value", account_id);
    if (!row || row->account.disabled) return SignInAgain();
    Principal principal = PrincipalOf(row->ToAccount());
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
                 "",
                 "not_from_page"};
  }
  return found;
}

core::Result<Principal> Accounts::ByKey(std::string_view secret, WallTime now) {
  const std::string hash = HashSecret(secret);
  return database_.Read([&](Transaction& tx) -> core::Result<Principal> {
    const Error refused = core::Refuse("api_key_unknown");
    const auto key = SelectRow<ApiKey>(tx, "api_key WHERE key_hash = :hash", {{"hash", hash}});
    if (!key || key->revoked || now >= key->expires_at) return refused;
    const auto row = account_rows::Find(tx, "id = :value", key->account_id);
    if (!row || row->account.disabled) return refused;
    Principal principal = PrincipalOf(row->ToAccount());
    principal.account_role = principal.role;
    principal.role = Role::kService;
    principal.proof = Proof::kApiKey;
    principal.api_key_id = key->id;
    principal.scopes = key->scopes;
    return principal;
  });
}

core::Result<bool> Accounts::Holds(const Principal& who, WallTime now) {
  return database_.Read([&](Transaction& tx) {
    if (who.proof == Proof::kApiKey) {
      return CountRows(tx,
                       "api_key k JOIN account a ON a.id = k.account_id WHERE k.id = :key AND "
                       "k.revoked = 0 AND k.expires_ms > :now AND a.disabled = 0",
                       {{"key", who.api_key_id}, {"now", now}}) > 0;
    }
    return CountRows(tx,
                     "sign_in s JOIN account a ON a.id = s.account_id WHERE s.token_hash = :hash "
                     "AND s.expires_ms > :now AND a.disabled = 0 AND a.role = :role",
                     {{"hash", who.session_token_hash}, {"now", now}, {"role", Name(who.role)}}) >
           0;
  });
}

SignInOutcome Accounts::SignIn(const SignInRequest& request, WallTime now) {
  const auto normal = NormalLogin(request.login);
  const std::string login = normal.ok() ? normal.value() : "?";
  struct Known {
    std::optional<account_rows::Row> row;
    bool device = false;
    bool network = false;
  };
  const std::string device = HashSecret(request.device);
  const auto found = database_.Read([&](Transaction& tx) {
    return Known{account_rows::Find(tx, "login = :value", login),
                 credentials::IsKnownDevice(tx, login, device),
                 credentials::IsKnownNetwork(tx, login, AddressKey(request.address))};
  });
  if (!found.ok()) return {found.error()};
  const std::optional<account_rows::Row>& row = found.value().row;
  const auto note = [&](const std::string& verb) {
    // An unknown login is not logged, because it may be a password typed into the wrong field.
    return AuditNote{Principal{},
                     verb,
                     row ? OwnerKeyOf(row->account.id) : "unknown login",
                     "from " + request.address};
  };
  auto pass = limits_.Begin({.account = login,
                             .address = request.address,
                             .device = found.value().device ? device : "",
                             .network_is_known = found.value().network},
                            now);
  if (!pass.ok()) return {pass.error(), note("sign_in_throttled")};
  const bool usable = row.has_value() && !row->account.disabled;
  const auto right = hasher_.Verify(usable ? row->password_hash : "", request.password);
  if (!right.ok()) {
    pass.value().NotJudged();
    return {right.error()};
  }
  if (!right.value()) return {WrongCredentials(), note("sign_in_failed")};
  auto opened =
      OpenSignIn(row->ToAccount(), row->password_hash, request.address, request.device, now);
  if (!opened.ok()) {
    pass.value().NotJudged();
    return {opened.error()};
  }
  pass.value().Succeeded();
  AuditNote success = note("sign_in");
  success.who = opened.value().principal;
  return {std::move(opened), std::move(success)};
}

core::Result<SignedIn> Accounts::OpenSignIn(const Account& account,
                                            const std::optional<std::string>& password_hash,
                                            const std::string& address,
                                            const std::string& device,
                                            WallTime now) {
  SignedIn out;
  out.cookie_secret = NewSecret("fls_");
  out.principal = PrincipalOf(account);
  out.principal.proof = Proof::kSessionCookie;
  out.principal.csrf_token = NewSecret("");
  out.principal.session_token_hash = HashSecret(out.cookie_secret);
  TRY_DONE(database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto row = account_rows::Find(tx, "id = :value", account.id);
    const bool still = row && !row->account.disabled &&
                       (!password_hash.has_value() || row->password_hash == *password_hash);
    if (!still) return WrongCredentials();
    const bool known = credentials::IsKnownDevice(tx, account.login, HashSecret(device));
    out.device_secret = known ? device : NewSecret("fld_");
    credentials::RememberDevice(
        tx, account.id, HashSecret(out.device_secret), AddressKey(address), now);
    credentials::AddSignIn(
        tx, {out.principal.session_token_hash, account.id, out.principal.csrf_token, address}, now);
    return Done{};
  }));
  return out;
}

core::Status Accounts::SignOut(const Principal& who) {
  const auto ended = database_.Write(Durability::kPromise, [&](Transaction& tx) {
    DeleteFrom(tx, "sign_in", {{"token_hash", who.session_token_hash}});
  });
  if (ended.ok()) {
    Tell({.what = Revocation::What::kSignIn,
          .account_id = who.user_id,
          .sign_in = who.session_token_hash});
  }
  return ended;
}

}  // namespace faultlab::server
