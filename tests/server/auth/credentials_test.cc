#include "server/auth/credentials.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/auth/calendar_links.h"
#include "tests/server/auth/accounts_fixture.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using std::chrono::hours;
using testing::HasSubstr;
using testing::SizeIs;

const std::string kHome = "192.0.2.1";

class CredentialsTest : public testing::TestWithParam<Engine> {
 protected:
  void SetUp() override {
    ann_ = accounts_.Create("ann", "Ann", Role::kStudent, kNow).value();
    SetPassword(ann_.id);
  }
  void SetPassword(std::int64_t account) {
    const auto link = accounts_.CreateLink(account, kNow).value();
    ASSERT_TRUE(accounts_.UseLink(link, kPassword, kNow).ok());
  }
  SignInOutcome SignIn(const std::string& password,
                       const std::string& address,
                       const std::string& device = "",
                       const std::string& login = "ann") {
    return accounts_.SignIn({login, password, address, device}, kNow);
  }
  /// Makes wrong tries until the account itself is limited, from all networks.
  void Besiege() {
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 5; ++j) {
        ASSERT_EQ(
            SignIn("wrong password", "198.51.100." + std::to_string(i)).signed_in.error().code,
            ErrorCode::kUnauthorized);
      }
    }
  }
  /// Everything that lets ann in besides her password.
  struct Held {
    SignedIn here;
    std::string key;
    std::string calendar;
  };
  Held TakeEverything() {
    Held held;
    held.here = SignIn(kPassword, kHome).signed_in.value();
    held.key = accounts_.CreateKey(held.here.principal, "k", {"jobs"}, kNow + hours(1), kNow)
                   .value()
                   .secret;
    held.calendar = calendars_.Create(ann_.id, kNow).value();
    return held;
  }
  bool KeyWorks(const std::string& secret) {
    const std::string header = "Bearer " + secret;
    RequestCredentials credentials;
    credentials.authorization = header;
    return accounts_.Authenticate(credentials, kNow).ok();
  }
  bool CookieWorks(const std::string& secret) {
    const std::string header = "faultlab_session=" + secret;
    RequestCredentials credentials;
    credentials.cookie = header;
    return accounts_.Authenticate(credentials, kNow).ok();
  }
  bool DeviceIsKnown(const std::string& secret) {
    return database_
        ->Read([&](Transaction& tx) -> core::Result<bool> {
          return credentials::IsKnownDevice(tx, "ann", HashSecret(secret));
        })
        .value();
  }
  std::int64_t Count(const std::string& table) {
    std::int64_t count = -1;
    EXPECT_TRUE(database_
                    ->Read([&](Transaction& tx) -> core::Status {
                      tx.sql() << "SELECT COUNT(*) FROM " + table, soci::into(count);
                      return core::Done{};
                    })
                    .ok());
    return count;
  }
  tests::TestDatabase database_{GetParam()};
  Accounts accounts_{*database_, GuestAccess::kNever, PasswordCost::kLeast};
  CalendarLinks calendars_{*database_};
  Account ann_;
};

TEST_P(CredentialsTest, TheOwnerSignsInOnHerLaptopWhileStrangersGuess) {
  const SignedIn before = SignIn(kPassword, kHome).signed_in.value();
  Besiege();
  EXPECT_EQ(SignIn(kPassword, "203.0.113.9").signed_in.error().code, ErrorCode::kTooMany)
      << "a place where she never was is as good as any stranger's";
  EXPECT_TRUE(SignIn(kPassword, kHome).signed_in.ok()) << "in a private window at home";
  const auto again = SignIn(kPassword, "203.0.113.9", before.device_secret);
  ASSERT_TRUE(again.signed_in.ok()) << again.signed_in.error().message;
  EXPECT_EQ(again.signed_in.value().device_secret, before.device_secret) << "still the same laptop";
  EXPECT_NE(again.signed_in.value().cookie_secret, before.cookie_secret);
  EXPECT_EQ(Count("known_device"), 2) << "and the private window";
}

TEST_P(CredentialsTest, ADeviceIsKnownToTheAccountThatSignedInOnIt) {
  accounts_.Create("bob", "Bob", Role::kStudent, kNow).value();
  const SignedIn of_ann = SignIn(kPassword, kHome).signed_in.value();
  EXPECT_FALSE(database_
                   ->Read([&](Transaction& tx) -> core::Result<bool> {
                     return credentials::IsKnownDevice(tx, "bob", HashSecret(of_ann.device_secret));
                   })
                   .value());
  const SignedIn forged = SignIn(kPassword, kHome, "made up").signed_in.value();
  EXPECT_NE(forged.device_secret, "made up") << "nobody chooses a secret for somebody else";
  EXPECT_EQ(Count("known_device WHERE token_hash = '" + of_ann.device_secret + "'"), 0) << "hashed";
}

TEST_P(CredentialsTest, ANewPasswordEndsKeysIfTheOwnerSaysSo) {
  const Held held = TakeEverything();
  ASSERT_TRUE(
      accounts_.ChangePassword(held.here.principal, kPassword, "the second one", false, kNow).ok());
  EXPECT_FALSE(DeviceIsKnown(held.here.device_secret));
  EXPECT_TRUE(CookieWorks(held.here.cookie_secret));
  EXPECT_TRUE(KeyWorks(held.key));
  EXPECT_TRUE(calendars_.AccountOf(held.calendar).ok());
  ASSERT_TRUE(
      accounts_.ChangePassword(held.here.principal, "the second one", "the third one", true, kNow)
          .ok());
  EXPECT_FALSE(KeyWorks(held.key));
  EXPECT_FALSE(calendars_.AccountOf(held.calendar).ok());
  EXPECT_TRUE(CookieWorks(held.here.cookie_secret));
}

TEST_P(CredentialsTest, AResetEndsWhateverElseLetSomebodyIn) {
  const Held held = TakeEverything();
  const std::string link = accounts_.CreateLink(ann_.id, kNow).value();
  EXPECT_TRUE(KeyWorks(held.key)) << "a link that nobody has used ends nothing";
  EXPECT_EQ(accounts_.UseLink(link, "the second one", kNow).value(), ann_.id);
  EXPECT_FALSE(CookieWorks(held.here.cookie_secret));
  EXPECT_FALSE(DeviceIsKnown(held.here.device_secret));
  EXPECT_FALSE(KeyWorks(held.key));
  EXPECT_FALSE(calendars_.AccountOf(held.calendar).ok());
  EXPECT_FALSE(accounts_.UseLink(link, "the third one", kNow).ok());
}

TEST_P(CredentialsTest, WhatADisabledAccountHadDoesNotComeBackWithIt) {
  const Held held = TakeEverything();
  const std::string link = accounts_.CreateLink(ann_.id, kNow).value();
  const auto change = [&](bool disabled) {
    const Account now = accounts_.Get(ann_.id).value();
    ASSERT_TRUE(accounts_.Change(ann_.id, now.version, std::nullopt, std::nullopt, disabled).ok());
  };
  change(true);
  change(false);
  EXPECT_FALSE(CookieWorks(held.here.cookie_secret));
  EXPECT_FALSE(DeviceIsKnown(held.here.device_secret));
  EXPECT_FALSE(KeyWorks(held.key));
  EXPECT_FALSE(calendars_.AccountOf(held.calendar).ok());
  EXPECT_FALSE(accounts_.UseLink(link, "the second one", kNow).ok());
  EXPECT_TRUE(SignIn(kPassword, kHome).signed_in.ok());
}

TEST_P(CredentialsTest, AnAccountKeepsItsNewestDevicesAndSignIns) {
  const auto add = [&](int i) {
    const std::string name = std::to_string(i);
    ASSERT_TRUE(database_
                    ->Write(Durability::kPromise,
                            [&](Transaction& tx) -> core::Status {
                              const WallTime at = kNow + std::chrono::seconds(i);
                              credentials::RememberDevice(tx, ann_.id, name, "", at);
                              credentials::AddSignIn(tx, {name, ann_.id, "csrf", kHome}, at);
                              return core::Done{};
                            })
                    .ok());
  };
  for (int i = 0; i < 210; ++i) add(i);
  EXPECT_EQ(Count("known_device"), 20);
  EXPECT_EQ(Count("sign_in"), 200);
  EXPECT_EQ(Count("sign_in WHERE token_hash = '209'"), 1);
}

TEST_P(CredentialsTest, SignInsAndFailuresAreWrittenDownAndAFloodIsCounted) {
  ManualClock clock;
  AuditLog audit(accounts_, clock, [](std::string_view) {});
  audit.AddBounded(*SignIn(kPassword, kHome).note);
  audit.AddBounded(*SignIn("wrong password", kHome).note);
  audit.AddBounded(*SignIn("wrong password", kHome, "", "my-secret-password").note);
  auto log = accounts_.ListAudit(0, 100).value();
  ASSERT_THAT(log, SizeIs(3));
  EXPECT_EQ(log[2].verb, "sign_in");
  EXPECT_EQ(log[2].actor, "user:" + std::to_string(ann_.id));
  EXPECT_EQ(log[1].verb, "sign_in_failed");
  EXPECT_EQ(log[1].actor, "guest");
  EXPECT_EQ(log[1].object_login, "ann");
  EXPECT_EQ(log[1].detail, "from " + kHome);
  EXPECT_EQ(log[0].object, "unknown login") << "it may have been the password";

  const AuditNote failed{Principal{}, "sign_in_failed", "user:7", "from somewhere"};
  for (int i = 0; i < 500; ++i) audit.AddBounded(failed);
  log = accounts_.ListAudit(0, 100).value();
  ASSERT_THAT(log, SizeIs(33));
  EXPECT_THAT(log[0].detail, HasSubstr("more of this hour are left out"));
  clock.Advance(hours(1));
  audit.AddBounded(failed);
  EXPECT_THAT(accounts_.ListAudit(0, 1).value()[0].detail, HasSubstr("470 before were left out"));
}

TEST_P(CredentialsTest, ALineOfARunNamesItsOwnerAlsoWithARemark) {
  const std::string of = "of user:" + std::to_string(ann_.id);
  ASSERT_TRUE(accounts_.Audit("system", "delete_run", "run:1", of, WallTime{}).ok());
  const std::string remark = of + "; more of this hour are left out";
  ASSERT_TRUE(accounts_.Audit("system", "delete_run", "run:2", remark, WallTime{}).ok());
  const auto log = accounts_.ListAudit(0, 10);
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_EQ(log.value()[1].object_login, "ann");
  EXPECT_EQ(log.value()[0].object_login, "") << "no number, and no reason to refuse the list";
}

TEST_P(CredentialsTest, AProgramInALoopDoesNotFillTheAuditLog) {
  ManualClock clock;
  AuditLog audit(accounts_, clock, [](std::string_view) {});
  Principal who;
  who.role = Role::kStudent;
  who.user_id = ann_.id;
  for (int i = 0; i < 300; ++i) audit.Add(who, "create_key", "key:" + std::to_string(i), "");
  audit.Add(who, "revoke_key", "key:1", "");
  EXPECT_THAT(accounts_.ListAudit(0, 1000).value(), SizeIs(201)) << "of each verb";
  who.user_id = 77;
  audit.Add(who, "create_key", "key:301", "");
  EXPECT_THAT(accounts_.ListAudit(0, 1000).value(), SizeIs(202)) << "of each person";
  clock.Advance(hours(1));
  who.user_id = ann_.id;
  audit.Add(who, "create_key", "key:302", "");
  EXPECT_THAT(accounts_.ListAudit(0, 1).value()[0].detail, HasSubstr("100 before were left out"));
  who.role = Role::kAdmin;
  for (int i = 0; i < 300; ++i) audit.Add(who, "role", "user:" + std::to_string(i), "");
  EXPECT_THAT(accounts_.ListAudit(0, 1000).value(), SizeIs(503)) << "an admin's are all there";
}

INSTANTIATE_TEST_SUITE_P(Engines, CredentialsTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
