#include "server/auth/accounts.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "tests/server/auth/accounts_fixture.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

TEST_P(AccountsTest, FirstStartGivesAnAdminLinkOnceAndNoDefaultPassword) {
  const auto link = accounts_.FirstStartLink("a", kNow).value();
  ASSERT_TRUE(link.has_value());
  EXPECT_EQ(SignIn("admin", "").error().code, ErrorCode::kUnauthorized);
  EXPECT_EQ(SignIn("admin", "admin").error().code, ErrorCode::kUnauthorized);
  ASSERT_TRUE(accounts_.UseLink(link->secret, kPassword, kNow).ok());
  EXPECT_EQ(accounts_.UseLink(link->secret, "another password", kNow).error().code,
            ErrorCode::kForbidden);
  EXPECT_EQ(SignIn("ADMIN", kPassword).value().principal.role, Role::kAdmin);
  EXPECT_FALSE(accounts_.FirstStartLink("a", kNow).value().has_value());
}

TEST_P(AccountsTest, TheFirstLinkOfAnotherServerStaysGood) {
  const std::string of_a = accounts_.FirstStartLink("a", kNow).value()->secret;
  const auto seen_by_b = accounts_.FirstStartLink("b", kNow).value();
  EXPECT_EQ(seen_by_b->secret, "");
  EXPECT_EQ(seen_by_b->made_by, "a");
  const std::string again = accounts_.FirstStartLink("a", kNow).value()->secret;
  EXPECT_NE(again, "") << "a server that is started again says its link again";
  EXPECT_FALSE(accounts_.UseLink(of_a, kPassword, kNow).ok());
  EXPECT_NE(accounts_.FirstStartLink("b", kNow + hours(25)).value()->secret, "") << "it is over";
  const std::int64_t admin = accounts_.GetByLogin("admin").value().id;
  const std::string by_hand = accounts_.CreateLink(admin, kNow).value();
  EXPECT_EQ(accounts_.FirstStartLink("a", kNow).value()->secret, "");
  EXPECT_TRUE(accounts_.UseLink(by_hand, kPassword, kNow).ok());
}

TEST_P(AccountsTest, AnAccountHasAHundredKeysAndKeepsAsManyThatAreOver) {
  const Account ann = Person("ann", Role::kStudent);
  const auto make = [&](WallTime now) {
    return accounts_.CreateKey(As(ann), "k", {"jobs"}, now + hours(1), now);
  };
  std::int64_t first = 0;
  for (int i = 0; i < Accounts::kLiveKeysMax; ++i) {
    const auto made = make(kNow);
    ASSERT_TRUE(made.ok());
    if (i == 0) first = made.value().key.id;
  }
  const auto refused = make(kNow);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "keys_full");
  ASSERT_TRUE(accounts_.RevokeKey(ann.id, first, kNow).ok());
  EXPECT_TRUE(make(kNow).ok()) << "revoking makes room";
  for (int i = 0; i < 150; ++i) {
    const auto made = make(kNow + hours(1));
    ASSERT_TRUE(made.ok()) << "and time does";
    ASSERT_TRUE(accounts_.RevokeKey(ann.id, made.value().key.id, kNow + hours(1)).ok());
  }
  const auto listed = accounts_.ListKeys(ann.id, kNow + hours(1)).value();
  EXPECT_EQ(listed.size(), static_cast<std::size_t>(Accounts::kPastKeysKept));
  EXPECT_TRUE(listed.back().revoked) << "the newest are kept";
}

TEST_P(AccountsTest, ALinkDiesAfterADayAndWhenANewerOneIsMade) {
  const Account ann = Person("ann", Role::kStudent);
  const auto first = accounts_.CreateLink(ann.id, kNow).value();
  const auto second = accounts_.CreateLink(ann.id, kNow).value();
  EXPECT_FALSE(accounts_.UseLink(first, kPassword, kNow).ok());
  EXPECT_FALSE(accounts_.UseLink(second, kPassword, kNow + hours(25)).ok());
  EXPECT_EQ(accounts_.UseLink(second, "short", kNow).error().field, "password");
  EXPECT_TRUE(accounts_.UseLink(second, kPassword, kNow).ok());
}

TEST_P(AccountsTest, ACookieSignsInUntilItEndsAndNothingSecretIsStored) {
  Person("ann", Role::kStudent, true);
  const SignedIn in = SignIn("ann", kPassword).value();
  const auto who = accounts_.Authenticate(WithCookie(in.cookie_secret), kNow);
  ASSERT_TRUE(who.ok());
  EXPECT_EQ(who.value().login, "ann");
  EXPECT_EQ(who.value().proof, Proof::kSessionCookie);
  EXPECT_EQ(accounts_.Authenticate(WithCookie(in.cookie_secret), kNow + hours(13)).error().code,
            ErrorCode::kUnauthorized);
  EXPECT_EQ(accounts_.Authenticate(WithCookie(in.cookie_secret + "x"), kNow).error().code,
            ErrorCode::kUnauthorized)
      << "a wrong cookie is never the guest";
  std::int64_t leaks = -1;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> core::Status {
                    tx.sql() << "SELECT (SELECT COUNT(*) FROM sign_in WHERE token_hash = :s) + "
                                "(SELECT COUNT(*) FROM account WHERE password_hash = :p)",
                        soci::into(leaks), soci::use(in.cookie_secret, "s"),
                        soci::use(kPassword, "p");
                    return core::Done{};
                  })
                  .ok());
  EXPECT_EQ(leaks, 0);
  ASSERT_TRUE(accounts_.SignOut(who.value()).ok());
  EXPECT_FALSE(accounts_.Authenticate(WithCookie(in.cookie_secret), kNow).ok());
}

TEST_P(AccountsTest, AChangeByCookieNeedsTheCsrfTokenAndTheOwnOrigin) {
  Person("ann", Role::kStudent, true);
  const SignedIn in = SignIn("ann", kPassword).value();
  RequestCredentials credentials = WithCookie(in.cookie_secret);
  credentials.changes_state = true;
  EXPECT_EQ(accounts_.Authenticate(credentials, kNow).error().code, ErrorCode::kForbidden);
  credentials.csrf_token = "guess";
  EXPECT_EQ(accounts_.Authenticate(credentials, kNow).error().code, ErrorCode::kForbidden);
  credentials.csrf_token = in.principal.csrf_token;
  EXPECT_TRUE(accounts_.Authenticate(credentials, kNow).ok());
  credentials.origin = "https://evil.example";
  EXPECT_EQ(accounts_.Authenticate(credentials, kNow).error().code, ErrorCode::kForbidden);
  credentials.origin = "https://lab.example";
  EXPECT_TRUE(accounts_.Authenticate(credentials, kNow).ok());
}

TEST_P(AccountsTest, GuestsAreLetInFromLoopbackOnly) {
  RequestCredentials credentials;
  credentials.remote_address = "127.0.0.1";
  EXPECT_EQ(accounts_.Authenticate(credentials, kNow).value().role, Role::kGuest);
  credentials.remote_address = "192.0.2.1";
  EXPECT_EQ(accounts_.Authenticate(credentials, kNow).error().code, ErrorCode::kUnauthorized);
}

TEST_P(AccountsTest, AChangedPasswordEndsTheOtherSignIns) {
  Person("ann", Role::kStudent, true);
  const SignedIn here = SignIn("ann", kPassword).value();
  const SignedIn elsewhere = SignIn("ann", kPassword).value();
  EXPECT_EQ(accounts_.ChangePassword(here.principal, "wrong one!", "new password!", false, kNow)
                .error()
                .field,
            "old");
  ASSERT_TRUE(
      accounts_.ChangePassword(here.principal, kPassword, "new password!", false, kNow).ok());
  EXPECT_TRUE(accounts_.Authenticate(WithCookie(here.cookie_secret), kNow).ok());
  EXPECT_FALSE(accounts_.Authenticate(WithCookie(elsewhere.cookie_secret), kNow).ok());
  EXPECT_FALSE(SignIn("ann", kPassword).ok());
  EXPECT_TRUE(SignIn("ann", "new password!").ok());
}

TEST_P(AccountsTest, AnApiKeyWorksUntilItExpiresOrIsRevokedAndIsKeptAsAHashOnly) {
  const Account ann = Person("ann", Role::kStudent);
  Principal who;
  who.user_id = ann.id;
  const auto key =
      accounts_.CreateKey(who, "bench robot", {"runs:read", "jobs"}, kNow + hours(24), kNow);
  ASSERT_TRUE(key.ok()) << key.error().message;
  const std::string header = "Bearer " + key.value().secret;
  RequestCredentials credentials;
  credentials.authorization = header;
  credentials.changes_state = true;  // a key is no cookie: no CSRF token needed
  const Principal service = accounts_.Authenticate(credentials, kNow).value();
  EXPECT_EQ(service.role, Role::kService);
  EXPECT_EQ(service.user_id, ann.id);
  EXPECT_EQ(service.scopes, (std::set<std::string>{"runs:read", "jobs"}));
  EXPECT_FALSE(accounts_.Authenticate(credentials, kNow + hours(24)).ok());
  const auto listed = accounts_.ListKeys(ann.id, kNow).value();
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].scopes, service.scopes);
  EXPECT_EQ(accounts_.RevokeKey(ann.id + 1, listed[0].id, kNow).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(accounts_.RevokeKey(ann.id, listed[0].id, kNow).ok());
  EXPECT_FALSE(accounts_.Authenticate(credentials, kNow).ok());
}

TEST_P(AccountsTest, RefusesKeysWithUnknownScopesOrForTenYears) {
  Principal who;
  who.user_id = Person("ann", Role::kStudent).id;
  const auto field = [&](const std::set<std::string>& scopes, WallTime until) {
    return accounts_.CreateKey(who, "k", scopes, until, kNow).error().field;
  };
  EXPECT_EQ(field({"root"}, kNow + hours(1)), "scopes");
  EXPECT_EQ(field({}, kNow + hours(1)), "scopes");
  EXPECT_EQ(field({"jobs"}, kNow), "expires_at");
  EXPECT_EQ(field({"jobs"}, kNow + hours(24 * 3650)), "expires_at");
}

TEST_P(AccountsTest, ADisabledAccountLosesSignInsAndKeysAtOnce) {
  const Account ann = Person("ann", Role::kStudent, true);
  const SignedIn in = SignIn("ann", kPassword).value();
  const auto key = accounts_.CreateKey(in.principal, "k", {"jobs"}, kNow + hours(1), kNow).value();
  EXPECT_EQ(accounts_.Change(ann.id, 99, std::nullopt, std::nullopt, true).error().code,
            ErrorCode::kStale);
  ASSERT_TRUE(accounts_.Change(ann.id, ann.version, std::nullopt, std::nullopt, true).ok());
  EXPECT_FALSE(accounts_.Authenticate(WithCookie(in.cookie_secret), kNow).ok());
  const std::string header = "Bearer " + key.secret;
  RequestCredentials credentials;
  credentials.authorization = header;
  EXPECT_FALSE(accounts_.Authenticate(credentials, kNow).ok());
  EXPECT_EQ(SignIn("ann", kPassword).error().code, ErrorCode::kUnauthorized);
}

TEST_P(AccountsTest, RefusesLoginsThatAreTakenOrUnreadable) {
  Person("ann", Role::kStudent);
  EXPECT_EQ(accounts_.Create("Ann", "x", Role::kStudent, kNow).error().code, ErrorCode::kConflict);
  for (const char* bad : {"", "ab", "with space", "näme", "a\nb", "x'; DROP TABLE account; --"}) {
    EXPECT_EQ(accounts_.Create(bad, "x", Role::kStudent, kNow).error().field, "login") << bad;
  }
  EXPECT_EQ(accounts_.Create("service", "x", Role::kService, kNow).error().field, "role");
}

TEST_P(AccountsTest, TheAuditLogOnlyGrows) {
  ASSERT_TRUE(accounts_.Audit("user:1", "quarantine", "rig bench-1", "smells", kNow).ok());
  ASSERT_TRUE(accounts_.Audit("user:2", "release", "rig bench-1", "", kNow).ok());
  const auto log = accounts_.ListAudit(0, 10).value();
  ASSERT_EQ(log.size(), 2u);
  EXPECT_EQ(log[0].verb, "release");
  EXPECT_EQ(accounts_.ListAudit(log[0].seq, 10).value().size(), 1u);
  for (const char* change : {"UPDATE audit_log SET actor = 'nobody'", "DELETE FROM audit_log"}) {
    const auto refused =
        database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
          tx.sql() << change;
          return core::Done{};
        });
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, AccountsTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
