#include <gmock/gmock.h>

#include "server/auth/accounts.h"
#include "server/auth/search_text.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr WallTime kNow{std::chrono::milliseconds{1'800'000'000'000}};

TEST(FoldLetters, FindsANameAsItIsTyped) {
  EXPECT_EQ(FoldLetters("Ana Ćirić"), "ana ciric");
  EXPECT_EQ(FoldLetters("Ана Ћирић, Љиља"), "ana ciric, ljilja");
  EXPECT_EQ(FoldLetters("Đ \xC4"), "d \xC4");
}

TEST(FoldCase, KnowsLatinWithDiacriticsAndCyrillic) {
  EXPECT_EQ(FoldCase("ĐORĐE Čolić Žika ŠĆ"), "đorđe čolić žika šć");
  EXPECT_EQ(FoldCase("ЂОРЂЕ Јелена Љиљана ЏАЈ"), "ђорђе јелена љиљана џај");
  EXPECT_EQ(FoldCase("Ångström ×"), "ångström ×");
  EXPECT_EQ(FoldCase("\xC4"), "\xC4") << "what is not UTF-8 stays";
}

class SearchTest : public testing::TestWithParam<Engine> {
 protected:
  std::vector<std::string> Found(const AccountFilter& filter, int limit = 10) {
    std::vector<std::string> logins;
    const auto found = accounts_.List(filter, 0, limit).value();
    for (const Account& each : found) logins.push_back(each.login);
    return logins;
  }
  std::vector<std::string> Lines(const AuditFilter& filter) {
    std::vector<std::string> lines;
    const auto found = accounts_.ListAudit(filter, 0, 10).value();
    for (const AuditEntry& each : found) lines.push_back(each.verb + " " + each.object);
    return lines;
  }

  tests::TestDatabase database_{GetParam()};
  Accounts accounts_{*database_, GuestAccess::kNever};
};

TEST_P(SearchTest, FindsAccountsByNameMailRoleAndCourse) {
  const auto ann = accounts_.Create("ann@uni.rs", "Ana Đurić", Role::kStudent, kNow).value();
  const auto bob = accounts_.Create("bob", "Ђорђе", Role::kInstructor, kNow).value();
  (void)accounts_.Create("cem_1", "Cem", Role::kStudent, kNow);
  EXPECT_THAT(Found({.text = "đURIĆ"}), ElementsAre("ann@uni.rs"));
  EXPECT_THAT(Found({.text = "UNI.rs"}), ElementsAre("ann@uni.rs"));
  EXPECT_THAT(Found({.text = "ђорђе"}), ElementsAre("bob"));
  EXPECT_THAT(Found({.text = "%"}), IsEmpty()) << "no pattern of SQL";
  EXPECT_THAT(Found({.text = "", .role = Role::kStudent}), ElementsAre("ann@uni.rs", "cem_1"));
  EXPECT_THAT(Found({.text = "", .role = Role::kStudent}, 1), ElementsAre("ann@uni.rs"));
  const Course course = accounts_.CreateCourse("DC motors", bob.id, kNow).value();
  ASSERT_TRUE(accounts_.Enrol(course.id, ann.id, false).ok());
  EXPECT_THAT(Found({.text = "", .course = course.id}), ElementsAre("ann@uni.rs", "bob"));
  EXPECT_THAT(Found({.text = "an", .role = Role::kStudent, .course = course.id}),
              ElementsAre("ann@uni.rs"));
}

TEST_P(SearchTest, FindsAuditLinesByWordsPersonAndTime) {
  const auto op = accounts_.Create("olga", "Olga", Role::kOperator, kNow).value();
  const std::string olga = "user:" + std::to_string(op.id);
  const auto minute = std::chrono::minutes(1);
  ASSERT_TRUE(accounts_.Audit(olga, "quarantine", "rig:bench-1", "smells of 50%", kNow).ok());
  ASSERT_TRUE(accounts_.Audit("system", "retention", "database", "", kNow + minute).ok());
  ASSERT_TRUE(accounts_.Audit(olga, "release", "rig:bench-1", "", kNow + 2 * minute).ok());
  EXPECT_THAT(Lines({.text = "BENCH-1"}),
              ElementsAre("release rig:bench-1", "quarantine rig:bench-1"));
  EXPECT_THAT(Lines({.text = "50%"}), ElementsAre("quarantine rig:bench-1"));
  EXPECT_THAT(Lines({.text = "0%s"}), IsEmpty());
  EXPECT_THAT(Lines({.text = "olga", .verbs = {"retention"}}),
              ElementsAre("release rig:bench-1", "retention database", "quarantine rig:bench-1"));
  EXPECT_THAT(Lines({.text = "", .verbs = {"release"}}), ElementsAre("release rig:bench-1"));
  EXPECT_THAT(Lines({.text = "", .verbs = {"x' OR '1' = '1"}}), IsEmpty());
  EXPECT_THAT(Lines({.text = "", .who = "OLG"}),
              ElementsAre("release rig:bench-1", "quarantine rig:bench-1"));
  EXPECT_THAT(Lines({.text = "", .from = kNow + minute, .to = kNow + 2 * minute}),
              ElementsAre("retention database"));
}

TEST_P(SearchTest, NamesTheCourseOfAnAuditLine) {
  const auto ann = accounts_.Create("ann", "Ann", Role::kInstructor, kNow).value();
  const Course course = accounts_.CreateCourse("DC motors", ann.id, kNow).value();
  const std::string object = "course:" + std::to_string(course.id);
  const std::string both = "user:999, user:" + std::to_string(ann.id);
  ASSERT_TRUE(accounts_.Audit("system", "invite", object, both, kNow).ok());
  ASSERT_TRUE(accounts_.Audit("system", "invite", "course:999", "user:999", kNow).ok());
  ASSERT_TRUE(accounts_.Audit("system", "create_course", "course:998", both, kNow).ok());
  const auto lines = accounts_.ListAudit({}, 0, 10).value();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].detail, both) << "a course may be called so";
  EXPECT_EQ(lines[1].object_name, "") << "there is no such course";
  EXPECT_EQ(lines[2].object_name, "DC motors");
  EXPECT_EQ(lines[2].detail, "user:999, ann") << "by the login of today, if there is one";
  EXPECT_THAT(Lines({.text = "dc MOTORS"}), ElementsAre("invite " + object));
  EXPECT_THAT(Lines({.text = "ANN"}), ElementsAre("invite " + object)) << "who is in the list";
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(accounts_.Create("ann" + std::to_string(i), "Ann", Role::kStudent, kNow).ok());
  }
  const auto last = accounts_.Create("annz", "Ann", Role::kStudent, kNow).value();
  ASSERT_TRUE(
      accounts_.Audit("system", "enrol", object, "user:" + std::to_string(last.id), kNow).ok());
  EXPECT_THAT(Lines({.text = "ann"}), ElementsAre("enrol " + object, "invite " + object))
      << "also the last of many";
}

INSTANTIATE_TEST_SUITE_P(Engines, SearchTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
