#include "server/storage/picture_store.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "server/storage/recording_store.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using testing::IsEmpty;
using testing::SizeIs;

class PictureStoreTest : public testing::TestWithParam<Engine> {
 protected:
  void Record(const std::string& id) {
    RunRecord record;
    record.id = id;
    record.owner = "user:1";
    record.source = "run";
    ASSERT_TRUE(recordings_.Begin(record).ok());
  }
  core::Status Add(std::int64_t sample, const std::string& why, const std::string& bytes = "x") {
    return pictures_.Add(
        "run-1", {.sample = sample, .why = why, .content_type = "image/jpeg"}, bytes);
  }

  tests::TestDatabase database_{GetParam()};
  RecordingStore recordings_{*database_};
  PictureStore pictures_{*database_};
};

TEST_P(PictureStoreTest, KeepsPicturesByTheirIndexAndBytes) {
  Record("run-1");
  std::string bytes = "\xFF\xD8\xFF";
  bytes += std::string(1000, '\0');
  ASSERT_TRUE(Add(100, "fault", bytes).ok());
  ASSERT_TRUE(Add(103, "detection").ok());
  const auto list = pictures_.List("run-1").value();
  ASSERT_THAT(list, SizeIs(2));
  EXPECT_EQ(list[0].index, 1);
  EXPECT_EQ(list[0].sample, 100);
  EXPECT_EQ(list[0].why, "fault");
  EXPECT_EQ(list[0].content_type, "image/jpeg");
  EXPECT_EQ(list[0].size_bytes, 1003);
  EXPECT_EQ(list[1].index, 2);
  EXPECT_EQ(pictures_.Load("run-1", 1).value(), bytes);
  EXPECT_EQ(pictures_.Load("run-1", 3).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(Add(100, "fault").error().code, ErrorCode::kConflict) << "this one is there";
}

TEST_P(PictureStoreTest, TheLastOfTwelvePlacesIsForTheEnd) {
  Record("run-1");
  for (int i = 1; i < PictureStore::kOfRunMax; ++i) ASSERT_TRUE(Add(i, "fault").ok());
  EXPECT_FALSE(pictures_.HasRoom("run-1", "detection").value());
  EXPECT_EQ(Add(50, "detection").error().code, ErrorCode::kConflict);
  EXPECT_TRUE(pictures_.HasRoom("run-1", "end").value());
  EXPECT_TRUE(Add(51, "end").ok());
  EXPECT_EQ(Add(52, "end").error().code, ErrorCode::kConflict);
  EXPECT_THAT(pictures_.List("run-1").value(), SizeIs(12));
}

TEST_P(PictureStoreTest, ARecordingTakesItsPicturesWithIt) {
  Record("run-1");
  ASSERT_TRUE(Add(1, "fault").ok());
  ASSERT_TRUE(recordings_.Finish("run-1", RunState::kFinished, WallTime{}, "{}", "").ok());
  ASSERT_TRUE(Add(2, "end").ok()) << "the end's comes after the end";
  ASSERT_TRUE(recordings_.Delete("run-1").ok());
  EXPECT_THAT(pictures_.List("run-1").value(), IsEmpty());
  EXPECT_FALSE(pictures_.Load("run-1", 1).ok());
  EXPECT_EQ(Add(3, "end").error().code, ErrorCode::kNotFound);
  const auto left = database_->Read([](Transaction& tx) -> core::Result<int> {
    int rows = 0;
    tx.sql() << "SELECT (SELECT COUNT(*) FROM blob_store) + (SELECT COUNT(*) FROM "
                "recording_picture)",
        soci::into(rows);
    return rows;
  });
  EXPECT_EQ(left.value(), 0);
}

TEST_P(PictureStoreTest, PicturesCountForTheQuotaOfTheOwnerAsSamplesOfTheSameSize) {
  Record("run-1");
  const std::int64_t before = recordings_.SamplesOf("user:1").value();
  ASSERT_TRUE(Add(1, "fault", std::string(30'000, 'x')).ok());
  EXPECT_EQ(recordings_.SamplesOf("user:1").value() - before, 1000);
  EXPECT_EQ(recordings_.SamplesOf("user:2").value(), 0);
}

INSTANTIATE_TEST_SUITE_P(Engines, PictureStoreTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
