#include "server/camera/picture_taker.h"

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "server/storage/recording_store.h"
#include "tests/support/await.h"
#include "tests/support/camera_site.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using tests::CameraSite;

class PictureTakerTest : public testing::Test {
 protected:
  PictureTakerTest() { Record("run-1"); }

  void Record(const std::string& id) {
    RunRecord record;
    record.id = id;
    record.owner = "guest";
    record.rig = "bench-1";
    record.source = "run";
    ASSERT_TRUE(recordings_.Begin(record).ok());
  }
  PictureTaker::Parts Parts() {
    return {cameras_,
            store_,
            clock_,
            disk_,
            [this](const PictureMoment&) { return still_shown_.load(); },
            [](std::string_view line) { ADD_FAILURE() << line; }};
  }
  /// "why@sample", once the camera was asked `asked` times and the taker has stopped.
  std::vector<std::string> Stored(PictureTaker& taker, int asked) {
    EXPECT_TRUE(tests::Await([&] { return site_.asked() >= asked; }));
    taker.Stop();
    std::vector<std::string> out;
    const auto pictures = store_.List("run-1").value();
    for (const StoredPicture& each : pictures) {
      out.push_back(each.why + "@" + std::to_string(each.sample));
    }
    return out;
  }

  /// Lets time pass until the camera was asked so often.
  bool AskedAgain(int asked) {
    return tests::Await([&] {
      clock_.Advance(std::chrono::seconds(1));
      return site_.asked() >= asked;
    });
  }

  CameraSite site_;
  ManualClock clock_;
  tests::TestDatabase database_{Engine::kSqlite};
  RecordingStore recordings_{*database_};
  PictureStore store_{*database_};
  DiskReserve disk_;
  std::atomic<bool> still_shown_{true};
  CameraReader cameras_{{{"bench-1", site_.url()}}, clock_, {}, {}};
};

TEST_F(PictureTakerTest, StoresThePictureOfAMomentWithItsRecording) {
  PictureTaker taker(Parts());
  taker.Note({"run-1", "bench-1", 1000, "fault"});
  taker.Note({"run-1", "sim-1", 1001, "fault"});  // has no camera
  EXPECT_THAT(Stored(taker, 1), ElementsAre("fault@1000"));
  EXPECT_EQ(store_.Load("run-1", 1).value(), CameraSite::Picture(1));
  EXPECT_EQ(store_.List("run-1").value()[0].content_type, "image/jpeg");
}

TEST_F(PictureTakerTest, APictureOfARigThatHasGoneToAnotherRunIsNotStored) {
  site_.Close();
  PictureTaker taker(Parts());
  taker.Note({"run-1", "bench-1", 1000, "end"});
  site_.WaitForAsked(1);
  still_shown_ = false;
  site_.Open();
  EXPECT_THAT(Stored(taker, 1), IsEmpty());
}

TEST_F(PictureTakerTest, ThePictureOfTheEndIsAskedForAgain) {
  site_.Answers("no picture");
  PictureTaker taker(Parts());
  taker.Note({"run-1", "bench-1", 1000, "end"});
  EXPECT_TRUE(AskedAgain(2));
  site_.Answers("");
  EXPECT_TRUE(AskedAgain(3));
  EXPECT_THAT(Stored(taker, 3), ElementsAre("end@1000"));
}

TEST_F(PictureTakerTest, ACameraThatStaysSilentIsLeftAlone) {
  site_.Answers("no picture");
  PictureTaker taker(Parts());
  taker.Note({"run-1", "bench-1", 1000, "end"});
  EXPECT_TRUE(AskedAgain(PictureTaker::kEndTries));
  clock_.Advance(std::chrono::hours(1));
  site_.Answers("");
  taker.Note({"run-1", "bench-1", 1001, "end"});
  EXPECT_TRUE(AskedAgain(PictureTaker::kEndTries + 1));
  EXPECT_THAT(Stored(taker, PictureTaker::kEndTries + 1), ElementsAre("end@1001"));
}

TEST_F(PictureTakerTest, APictureOfAMomentIsNotTakenLater) {
  site_.Answers("no picture");
  PictureTaker taker(Parts());
  taker.Note({"run-1", "bench-1", 1000, "fault"});
  site_.WaitForAsked(1);
  site_.Answers("");
  taker.Note({"run-1", "bench-1", 1001, "end"});
  EXPECT_TRUE(AskedAgain(2));
  EXPECT_THAT(Stored(taker, 2), ElementsAre("end@1001"));
}

TEST_F(PictureTakerTest, ARecordingThatWasDeletedMeanwhileGetsNoPicture) {
  site_.Close();
  PictureTaker taker(Parts());
  taker.Note({"run-1", "bench-1", 1000, "end"});
  site_.WaitForAsked(1);
  ASSERT_TRUE(recordings_.Finish("run-1", RunState::kFinished, clock_.Wall(), "{}", "").ok());
  ASSERT_TRUE(recordings_.Delete("run-1").ok());
  site_.Open();
  EXPECT_THAT(Stored(taker, 1), IsEmpty());
  EXPECT_FALSE(store_.Load("run-1", 1).ok());
}

TEST_F(PictureTakerTest, AFullDiskGetsNoPicture) {
  disk_ = {".", INT64_MAX};
  PictureTaker taker(Parts());
  taker.Note({"run-1", "bench-1", 1000, "end"});
  disk_ = {};
  PictureTaker with_room(Parts());
  with_room.Note({"run-1", "bench-1", 1001, "end"});
  EXPECT_THAT(Stored(with_room, 1), ElementsAre("end@1001"));
}

}  // namespace
}  // namespace faultlab::server
