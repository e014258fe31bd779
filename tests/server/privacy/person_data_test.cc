#include "server/privacy/person_data.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include <set>

#include "server/auth/accounts.h"
#include "server/idempotency/idempotency_store.h"
#include "server/storage/picture_store.h"
#include "server/storage/recording_store.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using testing::Contains;
using testing::ElementsAre;

constexpr WallTime kNow{std::chrono::milliseconds{1'770'000'000'000}};

class PersonDataTest : public testing::TestWithParam<Engine> {
 protected:
  std::int64_t Person(const std::string& login, const std::string& name) {
    return accounts_.Create(login, name, Role::kStudent, kNow).value().id;
  }
  static std::string Key(std::int64_t id) { return "user:" + std::to_string(id); }
  void Log(const std::string& actor,
           const std::string& verb,
           const std::string& object,
           const std::string& detail) {
    ASSERT_TRUE(accounts_.Audit(actor, verb, object, detail, kNow).ok());
  }
  void Record(const std::string& id,
              std::int64_t owner,
              const std::string& name,
              const std::string& plan) {
    RunRecord record;
    record.id = id;
    record.owner = Key(owner);
    record.name = name;
    record.source = "run";
    record.plan_json = plan;
    record.created_at = kNow + std::chrono::seconds(++recordings_);
    ASSERT_TRUE(store_.Begin(record).ok());
    ASSERT_TRUE(store_.Finish(id, RunState::kFinished, kNow, "{}", "nominal").ok());
  }
  /// "object: detail", oldest first, without the line of the erasure.
  std::vector<std::string> Lines() {
    std::vector<std::string> lines;
    const auto log = accounts_.ListAudit(0, 200).value();
    for (const AuditEntry& entry : log) {
      if (entry.verb == "erase_account") continue;
      lines.insert(lines.begin(), entry.object + ": " + entry.detail);
    }
    return lines;
  }
  PersonTable Exported(std::int64_t id, const std::string& name) {
    const auto tables = PersonData(*database_, id).value();
    for (const PersonTable& table : tables) {
      if (table.name == name) return table;
    }
    ADD_FAILURE() << "no table " << name;
    return {};
  }
  tests::TestDatabase database_{GetParam()};
  Accounts accounts_{*database_, GuestAccess::kNever, PasswordCost::kLeast};
  RecordingStore store_{*database_};
  int recordings_ = 0;
};

TEST_P(PersonDataTest, TheLogIsNotChangedAndShowsWhoIsErasedByTheNumber) {
  const std::int64_t ann = Person("ann", "Ann Other");
  const std::int64_t vic = Person("vic", "Vic Toria");
  const Principal who = PrincipalOf(accounts_.Get(ann).value());
  const Course course = accounts_.CreateCourse("Motors", ann, kNow).value();
  ASSERT_TRUE(accounts_.EnrolCsv(who, course.id, "vic,Vic\nnew,New\n", kNow).ok());
  Log(Key(vic), "sign_in", Key(vic), "from 192.0.2.1");
  Log(Key(ann), "quarantine", "rig:vic", "vic broke it");
  const std::string of = "course:" + std::to_string(course.id) + ": ";
  EXPECT_THAT(
      Lines(),
      ElementsAre(of + "new", of + "vic", Key(vic) + ": from 192.0.2.1", "rig:vic: vic broke it"));
  ASSERT_TRUE(ErasePerson(*database_, vic, kNow).ok());
  EXPECT_THAT(Lines(),
              ElementsAre(of + "new",
                          of + "erased-" + std::to_string(vic),
                          Key(vic) + ": from 192.0.2.1",
                          "rig:vic: vic broke it"));
}

TEST_P(PersonDataTest, NobodyHasTheLoginThatAnErasureGives) {
  const std::int64_t ann = Person("ann", "Ann Lee");
  const std::int64_t bob = Person("bob", "Bob");
  const std::string login = "erased-" + std::to_string(ann);
  EXPECT_EQ(accounts_.Create(login, "Eve", Role::kStudent, kNow).error().reason, "login_wrong");
  // An older program let somebody have it.
  ASSERT_TRUE(database_
                  ->Write(Durability::kPromise,
                          [&](Transaction& tx) -> core::Status {
                            tx.sql() << "UPDATE account SET login = :login WHERE id = :id",
                                soci::use(login, "login"), soci::use(bob, "id");
                            return core::Done{};
                          })
                  .ok());
  ASSERT_TRUE(ErasePerson(*database_, ann, kNow).ok());
  EXPECT_EQ(accounts_.Get(ann).value().login, login + "-2");
  EXPECT_EQ(accounts_.Get(bob).value().login, login);
}

TEST_P(PersonDataTest, ReplaysThatOthersMadeAreNamedByTheIdAfterwards) {
  const std::int64_t ann = Person("ann", "Ann");
  const std::int64_t vic = Person("vic", "Vic");
  Record("r1", vic, "run of vic", "{}");
  Record("r2", ann, "replay of run of vic", R"({"recording":"r1"})");
  Record("r3", ann, "replay of replay of run of vic", R"({"recording":"r2"})");
  Record("r4", ann, "replay of run of vic", R"({"recording":"r9"})");
  Record("r5", ann, "my own name", R"({"recording":"r1"})");
  ASSERT_TRUE(ErasePerson(*database_, vic, kNow).ok());
  EXPECT_EQ(store_.Get("r2").value().name, "replay of r1");
  EXPECT_EQ(store_.Get("r3").value().name, "replay of replay of r1");
  EXPECT_EQ(store_.Get("r4").value().name, "replay of run of vic") << "of something else";
  EXPECT_EQ(store_.Get("r5").value().name, "my own name");
}

TEST_P(PersonDataTest, TheExportHasRememberedAnswersAndLinesOfOthersAboutThePersonAlone) {
  const std::int64_t ann = Person("ann", "Ann");
  const std::int64_t vic = Person("vic", "Vic");
  IdempotencyStore answers(*database_);
  ASSERT_TRUE(answers.Begin(Key(vic), "key-1", "hash", kNow).ok());
  ASSERT_TRUE(answers.Finish(Key(vic), "key-1", 202, "{}").ok());
  Log(Key(ann), "enrol", "course:1", Key(1000 + vic) + ", " + Key(vic) + ", " + Key(ann));
  Log(Key(ann), "enrol", "course:1", Key(10 * vic) + ", " + Key(ann));
  Log("system", "create_course", "course:2", Key(1000 + vic) + ", " + Key(vic));
  EXPECT_EQ(Exported(vic, "remembered_answer").rows.size(), 1u);
  const PersonTable log = Exported(vic, "audit_log");
  ASSERT_EQ(log.rows.size(), 1u);
  EXPECT_EQ(log.rows[0].back(), Key(vic)) << "nobody else of the list";
  EXPECT_EQ(Exported(ann, "audit_log").rows.size(), 2u) << "what she wrote herself is whole";
}

TEST_P(PersonDataTest, PicturesOfThePersonsRunsAreExportedAndErased) {
  const std::int64_t ann = Person("ann", "Ann");
  const std::int64_t vic = Person("vic", "Vic");
  Record("r1", vic, "", "{}");
  Record("r2", ann, "", "{}");
  PictureStore pictures(*database_);
  const StoredPicture end{.why = "end", .content_type = "image/jpeg"};
  for (const char* run : {"r1", "r2"}) ASSERT_TRUE(pictures.Add(run, end, "bytes").ok());
  const PersonTable table = Exported(vic, "recording_picture");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][0], "r1");
  ASSERT_TRUE(ErasePerson(*database_, vic, kNow).ok());
  EXPECT_FALSE(pictures.Load("r1", 1).ok());
  EXPECT_TRUE(pictures.List("r1").value().empty());
  EXPECT_TRUE(pictures.Load("r2", 1).ok()) << "those of others stay";
}

TEST_P(PersonDataTest, WhatAGroupHasDoneTogetherStaysWithWhoIsLeft) {
  const std::int64_t ann = Person("ann", "Ann");
  const std::int64_t eva = Person("eva", "Eva");
  Record("run-shared", ann, "Exercise", "{}");
  Record("run-own", ann, "mine", "{}");
  const std::int64_t assignment = 5;
  ASSERT_TRUE(
      database_
          ->Write(
              Durability::kPromise,
              [&](Transaction& tx) -> core::Status {
                for (const std::int64_t member : {ann, eva}) {
                  tx.sql() << "INSERT INTO assignment_mate (assignment_id, account_id, "
                              "group_id) VALUES (:assignment, :member, 1)",
                      soci::use(assignment), soci::use(member);
                }
                for (const auto& [of, run] :
                     {std::pair<std::int64_t, std::string>{assignment, "run-shared"},
                      std::pair<std::int64_t, std::string>{assignment + 1, "run-own"}}) {
                  tx.sql() << "INSERT INTO trial (assignment_id, account_id, state, item, run, "
                              "commitment, nonce, truth, events, created_ms, ended_ms, answer, "
                              "answered_ms, grade, released_ms, why) VALUES (:of, :ann, "
                              "'answered', 0, :run, '', '', '', '[]', 1, 1, '{}', 1, '{}', 1, '')",
                      soci::use(of), soci::use(ann), soci::use(run);
                }
                return core::Done{};
              })
          .ok());
  ASSERT_TRUE(ErasePerson(*database_, ann, kNow).ok());
  EXPECT_EQ(store_.Get("run-shared").value().owner, Key(eva));
  EXPECT_FALSE(store_.Get("run-own").ok());
  std::vector<std::string> left;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> core::Status {
                    const soci::rowset<soci::row> rows =
                        (tx.sql().prepare << "SELECT run, grade FROM trial WHERE account_id = :eva",
                         soci::use(eva));
                    for (const soci::row& row : rows) left.push_back(row.get<std::string>(0));
                    return core::Done{};
                  })
                  .ok());
  EXPECT_THAT(left, ElementsAre("run-shared"));
}

TEST_P(PersonDataTest, EveryTableWithAPersonInItIsExported) {
  const std::string query =
      GetParam() == Engine::kSqlite
          ? "SELECT DISTINCT m.name FROM sqlite_master m, pragma_table_info(m.name) c WHERE "
            "m.type = 'table' AND c.name IN ('account_id', 'user_id', 'owner', 'actor')"
          : "SELECT DISTINCT CAST(table_name AS TEXT) FROM information_schema.columns WHERE "
            "table_schema = "
            "current_schema() AND column_name IN ('account_id', 'user_id', 'owner', 'actor')";
  std::set<std::string> with_person;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> core::Status {
                    const soci::rowset<std::string> rows = (tx.sql().prepare << query);
                    with_person.insert(rows.begin(), rows.end());
                    return core::Done{};
                  })
                  .ok());
  EXPECT_THAT(with_person, Contains("job")) << "the question finds something";
  with_person.erase("blob_store");  // of recordings, whose samples are exported as CSV
  std::set<std::string> exported;
  const auto tables = PersonData(*database_, Person("ann", "Ann")).value();
  for (const PersonTable& table : tables) {
    exported.insert(table.name);
  }
  for (const std::string& table : with_person) EXPECT_THAT(exported, Contains(table));
}

INSTANTIATE_TEST_SUITE_P(Engines, PersonDataTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
