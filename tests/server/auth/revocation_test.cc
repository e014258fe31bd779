#include "server/auth/revocation.h"

#include <gmock/gmock.h>

#include "server/auth/accounts.h"
#include "tests/server/auth/accounts_fixture.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using What = Revocation::What;
using testing::IsEmpty;
using testing::SizeIs;

class RevocationTest : public testing::Test {
 protected:
  void SetUp() override {
    ann_ = accounts_.Create("ann", "Ann", Role::kStudent, kNow).value();
    const auto link = accounts_.CreateLink(ann_.id, kNow).value();
    ASSERT_TRUE(accounts_.UseLink(link, kPassword, kNow).ok());
    accounts_.SetOnRevoked([this](const Revocation& revocation) { told_.push_back(revocation); });
  }
  Principal SignIn() {
    return accounts_.SignIn({"ann", kPassword, "192.0.2.1", ""}, kNow).signed_in.value().principal;
  }
  tests::TestDatabase database_{Engine::kSqlite};
  Accounts accounts_{*database_, GuestAccess::kNever, PasswordCost::kLeast};
  Account ann_;
  std::vector<Revocation> told_;
};

TEST_F(RevocationTest, SigningOutEndsThisSignInAlone) {
  const Principal here = SignIn();
  const Principal there = SignIn();
  ASSERT_TRUE(accounts_.SignOut(here).ok());
  ASSERT_THAT(told_, SizeIs(1));
  EXPECT_TRUE(Ends(told_[0], here));
  EXPECT_FALSE(Ends(told_[0], there));
}

TEST_F(RevocationTest, ANewPasswordEndsTheOtherSignInsAndLeavesKeys) {
  const Principal here = SignIn();
  const Principal there = SignIn();
  Principal key = here;
  key.proof = Proof::kApiKey;
  key.session_token_hash.clear();
  ASSERT_FALSE(accounts_.ChangePassword(here, "wrong", "a new long password", false, kNow).ok());
  EXPECT_THAT(told_, IsEmpty()) << "nothing is told of what did not happen";
  ASSERT_TRUE(accounts_.ChangePassword(here, kPassword, "a new long password", false, kNow).ok());
  ASSERT_THAT(told_, SizeIs(1));
  EXPECT_FALSE(Ends(told_[0], here));
  EXPECT_TRUE(Ends(told_[0], there));
  EXPECT_FALSE(Ends(told_[0], key));
}

TEST_F(RevocationTest, AResetANewRoleAndDisablingEndEverything) {
  const Principal here = SignIn();
  const auto link = accounts_.CreateLink(ann_.id, kNow).value();
  ASSERT_TRUE(accounts_.UseLink(link, kPassword, kNow).ok());
  ASSERT_TRUE(accounts_.Change(ann_.id, 1, "Ann B", std::nullopt, std::nullopt).ok());
  ASSERT_THAT(told_, SizeIs(1)) << "another name ends nothing";
  ASSERT_TRUE(accounts_.Change(ann_.id, 2, std::nullopt, Role::kOperator, std::nullopt).ok());
  ASSERT_TRUE(accounts_.Change(ann_.id, 3, std::nullopt, std::nullopt, true).ok());
  ASSERT_THAT(told_, SizeIs(3));
  Principal somebody_else = here;
  somebody_else.user_id = ann_.id + 1;
  for (const Revocation& revocation : told_) {
    EXPECT_TRUE(Ends(revocation, here));
    EXPECT_FALSE(Ends(revocation, somebody_else));
    EXPECT_FALSE(Ends(revocation, Principal{})) << "guests have nothing that could end";
  }
}

TEST_F(RevocationTest, ARevokedKeyEndsItselfAlone) {
  const Principal here = SignIn();
  const auto made = accounts_.CreateKey(here, "lab", {"lab"}, kNow + std::chrono::hours(1), kNow);
  ASSERT_TRUE(accounts_.RevokeKey(ann_.id, made.value().key.id, kNow).ok());
  ASSERT_THAT(told_, SizeIs(1));
  Principal key = here;
  key.proof = Proof::kApiKey;
  key.api_key_id = made.value().key.id;
  EXPECT_TRUE(Ends(told_[0], key));
  EXPECT_FALSE(Ends(told_[0], here));
  ++key.api_key_id;
  EXPECT_FALSE(Ends(told_[0], key));
}

TEST_F(RevocationTest, TheEndOfAnEnrolmentIsTold) {
  const auto teacher = accounts_.Create("tea", "Tea", Role::kInstructor, kNow).value();
  const auto course = accounts_.CreateCourse("Motors", teacher.id, kNow).value();
  ASSERT_TRUE(accounts_.Enrol(course.id, ann_.id, false).ok());
  ASSERT_TRUE(accounts_.EndEnrolment(course.id, ann_.id).ok());
  EXPECT_EQ(accounts_.EndEnrolment(course.id, ann_.id).error().code, core::ErrorCode::kNotFound);
  ASSERT_THAT(told_, SizeIs(1));
  EXPECT_EQ(told_[0].what, What::kCourse);
  EXPECT_EQ(told_[0].course_id, course.id);
  EXPECT_EQ(told_[0].account_id, ann_.id);
  EXPECT_FALSE(accounts_.Attends(ann_.id, course.id).value());
}

}  // namespace
}  // namespace faultlab::server
