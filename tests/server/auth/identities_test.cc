#include <gmock/gmock.h>

#include "server/auth/accounts.h"
#include "tests/server/auth/accounts_fixture.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using testing::SizeIs;

const std::string kIssuer = "https://login.example";

class IdentitiesTest : public testing::TestWithParam<Engine> {
 protected:
  VouchedPerson Person(const std::string& subject, const std::string& login) {
    return {kIssuer, subject, login, "Ana Anić", "state-" + std::to_string(++states_)};
  }
  core::Result<SignedIn> SignIn(const VouchedPerson& person, const NewcomerRules& rules = {}) {
    return accounts_.SignInByIdentity(person, rules, {"", "", "192.0.2.1", ""}, kNow).signed_in;
  }
  std::string Refusal(const VouchedPerson& person, const NewcomerRules& rules = {}) {
    const auto in = SignIn(person, rules);
    return in.ok() ? "" : in.error().reason;
  }
  tests::TestDatabase database_{GetParam()};
  Accounts accounts_{*database_, GuestAccess::kNever, PasswordCost::kLeast};
  int states_ = 0;
};

TEST_P(IdentitiesTest, ANewPersonGetsAnAccountAndComesBackToIt) {
  const Principal first = SignIn(Person("s-1", "Ann")).value().principal;
  EXPECT_EQ(first.login, "ann");
  EXPECT_EQ(first.name, "Ana Anić");
  EXPECT_EQ(first.role, Role::kStudent);
  const Principal again = SignIn(Person("s-1", "ann.changed")).value().principal;
  EXPECT_EQ(again.user_id, first.user_id) << "the subject says who it is, not the login";
  EXPECT_NE(again.session_token_hash, first.session_token_hash);
  VouchedPerson elsewhere = Person("s-1", "ann2");
  elsewhere.issuer = "https://other.example";
  EXPECT_NE(SignIn(elsewhere).value().principal.user_id, first.user_id);
}

TEST_P(IdentitiesTest, AnAccountThatExistsIsNotGivenToWhoeverHasItsLogin) {
  accounts_.Create("admin", "Admin", Role::kAdmin, kNow).value();
  accounts_.Create("ann", "Ann", Role::kStudent, kNow).value();
  EXPECT_EQ(Refusal(Person("s-1", "admin")), "oidc_login_taken");
  EXPECT_EQ(Refusal(Person("s-2", "ann")), "oidc_login_taken");
  EXPECT_EQ(Refusal(Person("s-3", "not a login")), "oidc_no_login");
  EXPECT_EQ(Refusal(Person("s-4", "new"), {.make_accounts = false}), "oidc_no_account");
}

TEST_P(IdentitiesTest, OnlyUnusedStudentsOfAClassListAreClaimed) {
  const NewcomerRules rules{.make_accounts = false, .claim_class_list = true};
  const Account ann = accounts_.Create("ann", "Ann", Role::kStudent, kNow).value();
  const Account bob = accounts_.Create("bob", "Bob", Role::kStudent, kNow).value();
  accounts_.Create("admin", "Admin", Role::kAdmin, kNow).value();
  ASSERT_TRUE(accounts_.UseLink(accounts_.CreateLink(bob.id, kNow).value(), kPassword, kNow).ok());
  EXPECT_EQ(SignIn(Person("s-1", "ann"), rules).value().principal.user_id, ann.id);
  EXPECT_EQ(Refusal(Person("s-2", "ann"), rules), "oidc_login_taken") << "claimed once";
  EXPECT_EQ(Refusal(Person("s-3", "bob"), rules), "oidc_login_taken") << "has a password";
  EXPECT_EQ(Refusal(Person("s-4", "admin"), rules), "oidc_login_taken") << "is no student";
}

TEST_P(IdentitiesTest, AnAnswerCountsOnce) {
  const VouchedPerson person = Person("s-1", "ann");
  ASSERT_TRUE(SignIn(person).ok());
  EXPECT_EQ(Refusal(person), "oidc_elsewhere");
  const std::int64_t ann = accounts_.GetByLogin("ann").value().id;
  EXPECT_EQ(accounts_.AddIdentity(ann, person, kNow).error().reason, "oidc_elsewhere");
}

TEST_P(IdentitiesTest, TheOwnerAddsAndRemovesAProvider) {
  const Account bob = accounts_.Create("bob", "Bob", Role::kStudent, kNow).value();
  ASSERT_TRUE(accounts_.AddIdentity(bob.id, Person("s-1", "x"), kNow).ok());
  EXPECT_EQ(SignIn(Person("s-1", "x")).value().principal.user_id, bob.id);
  EXPECT_THAT(accounts_.Identities(bob.id).value(), SizeIs(1));
  const Account eve = accounts_.Create("eve", "Eve", Role::kStudent, kNow).value();
  EXPECT_EQ(accounts_.AddIdentity(eve.id, Person("s-1", "x"), kNow).error().reason,
            "oidc_linked_elsewhere");
  EXPECT_EQ(accounts_.RemoveIdentity(bob.id, kIssuer).error().code, ErrorCode::kConflict)
      << "the only way in";
  EXPECT_EQ(accounts_.RemoveIdentity(eve.id, kIssuer).error().code, ErrorCode::kNotFound);
}

TEST_P(IdentitiesTest, ADisabledAccountStaysShutAndAResetEndsAddedProviders) {
  const Principal ann = SignIn(Person("s-1", "ann")).value().principal;
  ASSERT_TRUE(accounts_.AddIdentity(ann.user_id, Person("s-2", "intruder"), kNow).ok());
  const auto link = accounts_.CreateLink(ann.user_id, kNow).value();
  ASSERT_TRUE(accounts_.UseLink(link, kPassword, kNow).ok());
  EXPECT_EQ(SignIn(Person("s-1", "ann")).value().principal.user_id, ann.user_id);
  EXPECT_NE(SignIn(Person("s-2", "intruder")).value().principal.user_id, ann.user_id);
  ASSERT_TRUE(accounts_.Change(ann.user_id, 1, std::nullopt, std::nullopt, true).ok());
  EXPECT_EQ(Refusal(Person("s-1", "ann")), "oidc_disabled");
}

INSTANTIATE_TEST_SUITE_P(Engines, IdentitiesTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
