// Accounts: people authenticated by a sign-in provider.
#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/identity_rows.h"
#include "server/auth/person_name.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {

template <typename Visit>
void Fields(LinkedIdentity& identity, Visit&& visit) {
  visit("issuer", identity.issuer);
  visit("created_ms", identity.at);
}
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

constexpr auto kStateLives = std::chrono::hours(1);
constexpr std::size_t kDisplayBytesMax = 200;

Error NotLetIn(const std::string& reason, const std::string& message) {
  return {ErrorCode::kForbidden, message, "", reason};
}

/// The answer to a sign-in is accepted only once. Expired sign-ins are deleted.
core::Status UseUp(Transaction& tx, const std::string& state_hash, WallTime now) {
  Execute(tx, "DELETE FROM used_login WHERE expires_ms < :now", {{"now", now}});
  if (InsertInto(tx,
                 "used_login",
                 {{"state_hash", state_hash}, {"expires_ms", now + kStateLives}},
                 "ON CONFLICT (state_hash) DO NOTHING") != 1) {
    return NotLetIn("oidc_elsewhere", "this sign-in has been used");
  }
  return Done{};
}

void PutIdentity(
    Transaction& tx, const VouchedPerson& person, std::int64_t account, bool added, WallTime now) {
  InsertInto(tx,
             "external_identity",
             {{"issuer", person.issuer},
              {"subject", person.subject},
              {"account_id", account},
              {"added", added},
              {"created_ms", now}});
  // An address of a class list is for a link that nobody needs any more.
  DeleteFrom(tx, "mail_choice", {{"account_id", account}, {"verified_ms", 0}});
}

std::int64_t CountIdentities(Transaction& tx, std::int64_t account) {
  return CountRows(tx, "external_identity WHERE account_id = :id", {{"id", account}});
}

/// Made by a class list, and nobody has ever signed in to it.
bool IsUnclaimed(Transaction& tx, const account_rows::Row& row) {
  return row.password_hash.empty() && row.account.role == Role::kStudent && !row.account.disabled &&
         CountIdentities(tx, row.account.id) == 0;
}

std::string ShownAs(const std::string& name, const std::string& login) {
  std::string clean = CleanName(name);
  return clean.empty() || clean.size() > kDisplayBytesMax ? login : clean;
}

bool IsTaken(Transaction& tx, const std::string& login) {
  return account_rows::Find(tx, "login = :value", login).has_value();
}

}  // namespace

std::optional<std::int64_t> identity_rows::AccountOf(Transaction& tx, const VouchedPerson& person) {
  return SelectValue<std::int64_t>(
      tx,
      "SELECT account_id FROM external_identity WHERE issuer = :issuer AND subject = :subject",
      {{"issuer", person.issuer}, {"subject", person.subject}});
}

core::Result<Account> identity_rows::First(Transaction& tx,
                                           const VouchedPerson& person,
                                           const NewcomerRules& rules,
                                           WallTime now,
                                           std::int64_t made_by) {
  const auto login = NormalLogin(person.login);
  const auto row =
      login.ok() ? account_rows::Find(tx, "login = :value", login.value()) : std::nullopt;
  const bool claims = row && rules.claim_class_list && IsUnclaimed(tx, *row);
  const bool may_make = !claims && rules.make_accounts;
  const bool other = (!login.ok() || row) && may_make && !rules.other_login.empty();
  if (!login.ok() && !other) {
    return NotLetIn("oidc_no_login", "the provider names no login that is one here");
  }
  if (!claims && !rules.make_accounts && !row) {
    return NotLetIn("oidc_no_account", "the login " + login.value() + " has no account here");
  }
  if ((row && !claims && !other) || (other && IsTaken(tx, rules.other_login))) {
    return NotLetIn(
        "oidc_login_taken",
        "the login " + (other ? rules.other_login : login.value()) + " has an account here");
  }
  Account account;
  if (claims) {
    account = row->ToAccount();
  } else {
    const std::string& own = other ? rules.other_login : login.value();
    account = account_rows::Add(tx, own, ShownAs(person.name, own), rules.role, now, made_by);
  }
  PutIdentity(tx, person, account.id, /*added=*/false, now);
  return account;
}

core::Result<Account> Accounts::AdmitByIdentity(const VouchedPerson& person,
                                                const NewcomerRules& rules,
                                                WallTime now) {
  const std::string state_hash = HashSecret(person.state);
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Account> {
    if (const auto once = UseUp(tx, state_hash, now); !once.ok()) return once.error();
    auto known = identity_rows::AccountOf(tx, person);
    if (!known) {
      TakeTurn(tx, identity_rows::kTurn);
      known = identity_rows::AccountOf(tx, person);
    }
    if (!known) return identity_rows::First(tx, person, rules, now);
    const auto row = account_rows::Find(tx, "id = :value", *known);
    if (!row) return account_rows::NoAccount();
    if (row->account.disabled) return NotLetIn("oidc_disabled", "the account is disabled");
    if (!rules.staff && row->account.role != Role::kStudent &&
        row->account.role != Role::kInstructor) {
      return NotLetIn("lti_staff", "whoever runs the lab signs in here alone");
    }
    return row->ToAccount();
  });
}

core::Status Accounts::UseOnce(const std::string& state, WallTime now) {
  const std::string hash = HashSecret(state);
  return database_.Write(Durability::kPromise,
                         [&](Transaction& tx) { return UseUp(tx, hash, now); });
}

SignInOutcome Accounts::SignInByIdentity(const VouchedPerson& person,
                                         const NewcomerRules& rules,
                                         const SignInRequest& request,
                                         WallTime now) {
  const auto account = AdmitByIdentity(person, rules, now);
  if (!account.ok()) return {account.error()};
  auto opened = OpenSignIn(account.value(), std::nullopt, request.address, request.device, now);
  if (!opened.ok()) return {opened.error()};
  AuditNote note{opened.value().principal,
                 "sign_in",
                 opened.value().principal.owner_key(),
                 "from " + request.address};
  return {std::move(opened), std::move(note)};
}

core::Status Accounts::AddIdentity(std::int64_t account_id,
                                   const VouchedPerson& person,
                                   WallTime now) {
  const std::string state_hash = HashSecret(person.state);
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (const auto once = UseUp(tx, state_hash, now); !once.ok()) return once;
    if (const auto known = identity_rows::AccountOf(tx, person)) {
      if (*known == account_id) return Done{};
      return NotLetIn("oidc_linked_elsewhere", "this identity belongs to another account");
    }
    if (!account_rows::Find(tx, "id = :value", account_id)) return account_rows::NoAccount();
    PutIdentity(tx, person, account_id, /*added=*/true, now);
    return Done{};
  });
}

core::Result<std::vector<LinkedIdentity>> Accounts::Identities(std::int64_t account_id) {
  return database_.Read([&](Transaction& tx) {
    return SelectRows<LinkedIdentity>(
        tx,
        "external_identity WHERE account_id = :id ORDER BY created_ms, issuer",
        {{"id", account_id}});
  });
}

core::Status Accounts::RemoveIdentity(std::int64_t account_id, const std::string& issuer) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto row = account_rows::Find(tx, "id = :value", account_id);
    if (!row) return account_rows::NoAccount();
    if (DeleteFrom(tx, "external_identity", {{"account_id", account_id}, {"issuer", issuer}}) ==
        0) {
      return core::Refuse("no_identity");
    }
    if (row->password_hash.empty() && CountIdentities(tx, account_id) == 0) {
      return core::Refuse("only_way_in");
    }
    return Done{};
  });
}

}  // namespace faultlab::server
