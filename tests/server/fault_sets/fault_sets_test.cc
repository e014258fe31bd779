#include "server/fault_sets/fault_sets.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "server/auth/accounts.h"
#include "tests/support/engines.h"
#include "tests/support/insert_race.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using testing::ElementsAre;

FaultSet Named(const std::string& name, std::int64_t author) {
  FaultSet set;
  set.name = name;
  set.author = author;
  set.faults_json = "[]";
  return set;
}

class FaultSetsTest : public testing::TestWithParam<Engine> {
 protected:
  std::vector<std::string> NamesFor(std::optional<FaultSets::Reader> reader,
                                    std::int64_t after = 0,
                                    int limit = 50) {
    std::vector<std::string> names;
    const auto sets = sets_.List(reader, after, limit).value();
    for (const FaultSet& set : sets) names.push_back(set.name);
    return names;
  }
  tests::TestDatabase database_{GetParam()};
  FaultSets sets_{*database_};
};

TEST_P(FaultSetsTest, TheListHasWhatItsReaderMaySeeByPages) {
  Accounts accounts(*database_, GuestAccess::kNever, PasswordCost::kLeast);
  const WallTime now{};
  const auto person = [&](const char* login, Role role) {
    return accounts.Create(login, login, role, now).value().id;
  };
  const std::int64_t author = person("author", Role::kInstructor);
  const std::int64_t teacher = person("teacher", Role::kInstructor);
  const std::int64_t ann = person("ann", Role::kStudent);
  const std::int64_t course = accounts.CreateCourse("c", teacher, now).value().id;
  ASSERT_TRUE(accounts.Enrol(course, ann, false).ok());
  for (const bool in_course : {false, true}) {
    for (const bool visible : {false, true}) {
      FaultSet set = Named(
          std::string(in_course ? "course " : "own ") + (visible ? "shown" : "hidden"), author);
      set.course_id = in_course ? course : 0;
      set.visible = visible;
      ASSERT_TRUE(sets_.Create(set).ok());
    }
  }
  const auto makes = [](std::int64_t account) { return FaultSets::Reader{account, true}; };
  EXPECT_THAT(NamesFor(makes(author)),
              ElementsAre("own hidden", "own shown", "course hidden", "course shown"));
  EXPECT_THAT(NamesFor(makes(teacher)), ElementsAre("course hidden", "course shown"));
  EXPECT_THAT(NamesFor(FaultSets::Reader{ann, false}), ElementsAre("course shown"));
  EXPECT_THAT(NamesFor(FaultSets::Reader{teacher, false}), ElementsAre("course shown"))
      << "a student today";
  EXPECT_THAT(NamesFor(FaultSets::Reader{author, false}), ElementsAre());
  EXPECT_THAT(NamesFor(std::nullopt).size(), 4u);
  const std::int64_t second = sets_.List(makes(author), 0, 2).value()[1].id;
  EXPECT_THAT(NamesFor(makes(author), second, 1), ElementsAre("course hidden"));
}

TEST_P(FaultSetsTest, AnAuthorHasFiveHundredAndDeletingMakesRoom) {
  FaultSet made;
  for (int i = 0; i < FaultSets::kOfAuthorMax; ++i) {
    made = sets_.Create(Named("s", 1)).value();
  }
  EXPECT_EQ(sets_.Create(Named("s", 1)).error().reason, "fault_sets_full");
  EXPECT_TRUE(sets_.Create(Named("s", 2)).ok()) << "others have their own";
  ASSERT_TRUE(sets_.Delete(made.id, made.version).ok());
  EXPECT_TRUE(sets_.Create(Named("s", 1)).ok());
  std::int64_t rows = 0;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> core::Status {
                    tx.sql() << "SELECT COUNT(*) FROM fault_set", soci::into(rows);
                    return core::Done{};
                  })
                  .ok());
  EXPECT_EQ(rows, FaultSets::kOfAuthorMax + 1) << "what no run used is deleted for good";
}

TEST_P(FaultSetsTest, OfUsedSetsThatAreDeletedTheNewestAreKept) {
  const std::int64_t many = FaultSets::kOfAuthorMax + 100;
  const auto count = [&] {
    std::int64_t rows = 0;
    (void)database_->Read([&](Transaction& tx) -> core::Status {
      tx.sql() << "SELECT COUNT(*) FROM fault_set WHERE account_id = 1", soci::into(rows);
      return core::Done{};
    });
    return rows;
  };
  const auto filled = database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << "INSERT INTO fault_set (course_id, account_id, name, version, visible, faults, "
                "used, deleted, replaces, created_ms) WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL "
                "SELECT i + 1 FROM n WHERE i < :many) SELECT 0, 1, 's', 1, 1, '[]', 1, 1, 0, 0 "
                "FROM n",
        soci::use(many, "many");
    return core::Done{};
  });
  ASSERT_TRUE(filled.ok()) << filled.error().message;
  ASSERT_EQ(count(), many);
  const FaultSet last = sets_.Create(Named("last", 1)).value();
  ASSERT_TRUE(sets_.MarkUsed(last.id).ok());
  EXPECT_TRUE(sets_.Get(last.id).value().used);
  ASSERT_TRUE(sets_.Delete(last.id, last.version).ok());
  EXPECT_EQ(count(), FaultSets::kOfAuthorMax);
  EXPECT_THAT(NamesFor(FaultSets::Reader{1, true}), testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Engines, FaultSetsTest, tests::kBothEngines, tests::EngineName);

TEST(FaultSetRace, TheAnswerNamesTheSetThatWasMade) {
  tests::TestDatabase database(Engine::kPostgresql);
  const auto other = database.OpenAnother();
  FaultSets here(*database);
  FaultSets there(*other);
  tests::InsertRace race(database, "fault_set");
  std::int64_t first = 0;
  std::int64_t second = 0;
  race.Run([&] { first = here.Create(Named("first", 1)).value().id; },
           [&] { second = there.Create(Named("second", 2)).value().id; });
  EXPECT_EQ(here.Get(first).value().name, "first");
  EXPECT_EQ(here.Get(second).value().name, "second");
}

}  // namespace
}  // namespace faultlab::server
