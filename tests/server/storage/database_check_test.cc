#include "server/storage/database_check.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using testing::HasSubstr;

class DatabaseCheckTest : public ::testing::TestWithParam<Engine> {
 protected:
  DatabaseCheckTest() {
    for (const char* id : {"run-a", "run-b"}) {
      RunRecord record;
      record.id = id;
      record.owner = "guest";
      record.source = "run";
      EXPECT_TRUE(store_.Begin(record).ok());
      for (std::int64_t first = 0; first < 300; first += 100) {
        std::vector<core::Sample> samples(100);
        for (std::size_t i = 0; i < samples.size(); ++i) {
          samples[i].index = first + static_cast<std::int64_t>(i);
        }
        EXPECT_TRUE(store_.AppendChunk(id, first, samples).ok());
      }
    }
    EXPECT_TRUE(store_.Finish("run-a", RunState::kFinished, WallTime{}, "{}", "").ok());
  }
  void Sql(const std::string& statement) {
    const core::Status done =
        database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
          tx.sql() << statement;
          return core::Done{};
        });
    EXPECT_TRUE(done.ok());
  }
  /// The chunk of sample 100 is that of sample 0 once more.
  void Misplace() {
    Sql("UPDATE blob_store SET bytes = (SELECT bytes FROM blob_store WHERE owner = "
        "'recording:run-a' AND seq = 0) WHERE owner = 'recording:run-a' AND seq = 100");
  }

  tests::TestDatabase database_{GetParam()};
  RecordingStore store_{*database_};
};

TEST_P(DatabaseCheckTest, FindsNothingInAHealthyDatabaseNorInARunThatGoesOn) {
  EXPECT_TRUE(CheckDatabase(*database_).ok());
}

TEST_P(DatabaseCheckTest, FindsWhatFaultlabHasNotMade) {
  if (GetParam() != Engine::kSqlite) return;
  const auto said = [this] {
    const core::Status found = CheckSchema(*database_);
    return found.ok() ? std::string() : found.error().message;
  };
  Sql("CREATE INDEX of_the_operator ON account (name)");
  EXPECT_EQ(said(), "");
  Sql("CREATE TRIGGER evil AFTER INSERT ON account BEGIN UPDATE account SET role = 'admin'; END");
  EXPECT_THAT(said(), HasSubstr("trigger evil is not faultlab's"));
  Sql("DROP TRIGGER evil");
  EXPECT_EQ(said(), "");
  Sql("DROP TABLE trial");
  EXPECT_THAT(said(), HasSubstr("table trial is missing"));
}

TEST_P(DatabaseCheckTest, FindsAChunkThatHasChanged) {
  const bool sqlite = GetParam() == Engine::kSqlite;
  Sql(sqlite ? "UPDATE blob_store SET bytes = CAST(substr(bytes, 1, 40) || x'5a' || substr(bytes, "
               "42) AS BLOB) WHERE owner = 'recording:run-a' AND seq = 100"
             : "UPDATE blob_store SET bytes = set_byte(bytes, 40, 90) WHERE owner = "
               "'recording:run-a' AND seq = 100");
  const core::Status found = CheckDatabase(*database_);
  ASSERT_FALSE(found.ok());
  EXPECT_THAT(found.error().message, HasSubstr("run-a"));
  EXPECT_THAT(found.error().message, Not(HasSubstr("run-b")));
}

TEST_P(DatabaseCheckTest, FindsAChunkThatIsNotThere) {
  Sql("DELETE FROM blob_store WHERE owner = 'recording:run-a' AND seq = 200");
  const auto found = FindDamagedRecordings(*database_);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found.value().size(), 1u);
  EXPECT_EQ(found.value()[0].id, "run-a");
  EXPECT_EQ(found.value()[0].what, "200 of its 300 samples are there");
}

TEST_P(DatabaseCheckTest, FindsAChunkAtTheWrongPlace) {
  Misplace();
  EXPECT_FALSE(CheckDatabase(*database_).ok());
}

TEST_P(DatabaseCheckTest, WhatIsDamagedCanBeCutOutAndTheRestIsRead) {
  Misplace();
  const auto lost = CutDamage(*database_, "run-a", [](std::int64_t index, std::int64_t samples) {
    return RecordedEvent{index, "gap", "{\"lost\":" + std::to_string(samples) + "}"};
  });
  ASSERT_TRUE(lost.ok()) << lost.error().message;
  EXPECT_EQ(lost.value(), 100);
  EXPECT_TRUE(CheckDatabase(*database_).ok());
  EXPECT_EQ(store_.LoadSamples("run-a").value().size(), 200u);
  EXPECT_EQ(store_.Get("run-a").value().samples, 200);
  const auto events = store_.LoadEvents("run-a").value();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].index, 100);
  EXPECT_EQ(events[0].json, "{\"lost\":100}");
}

TEST_P(DatabaseCheckTest, FindsOneAmongMoreThanAPage) {
  for (int i = 0; i < 450; ++i) {
    RunRecord record;
    record.id = "run-c" + std::to_string(i);
    record.source = "run";
    ASSERT_TRUE(store_.Begin(record).ok());
  }
  Sql("UPDATE recording SET samples = 7, state = 'finished' WHERE id = 'run-c449'");
  const auto found = FindDamagedRecordings(*database_);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found.value().size(), 1u);
  EXPECT_EQ(found.value()[0].id, "run-c449");
}

INSTANTIATE_TEST_SUITE_P(Engines, DatabaseCheckTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
