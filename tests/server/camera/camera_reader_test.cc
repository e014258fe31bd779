#include "server/camera/camera_reader.h"

#include <gmock/gmock.h>

#include <mutex>
#include <thread>
#include <vector>

#include "tests/support/camera_site.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using tests::CameraSite;

class CameraReaderTest : public testing::Test {
 protected:
  CameraReader Reader(CameraReader::Limits limits = {}, milliseconds timeout = milliseconds(2000)) {
    return {{{"bench-1", site_.url(), timeout}, {"bench-2", other_.url()}},
            clock_,
            limits,
            [this](std::string_view line) {
              const std::lock_guard lock(mutex_);
              log_.emplace_back(line);
            }};
  }
  static std::string Failure(CameraReader& reader) {
    const auto answer = reader.Look("bench-1");
    if (answer.ok()) return "a picture";
    EXPECT_EQ(answer.error().code, ErrorCode::kUnavailable);
    return answer.error().message;
  }

  CameraSite site_;
  CameraSite other_;
  ManualClock clock_;
  std::mutex mutex_;
  std::vector<std::string> log_;
};

TEST_F(CameraReaderTest, NobodyLooksAndNothingIsAsked) {
  CameraReader reader = Reader();
  EXPECT_TRUE(reader.Has("bench-1"));
  EXPECT_FALSE(reader.Has("bench-3"));
  EXPECT_EQ(reader.Look("bench-3").error().code, ErrorCode::kNotFound);
  clock_.Advance(std::chrono::hours(1));
  EXPECT_EQ(site_.asked(), 0);
}

TEST_F(CameraReaderTest, APictureIsSharedForSomeTimeAndThenAskedForAgain) {
  CameraReader reader = Reader();
  const auto first = reader.Look("bench-1").value();
  EXPECT_EQ(first->bytes, CameraSite::Picture(1));
  EXPECT_EQ(first->content_type, "image/jpeg");
  EXPECT_EQ(first->asked, clock_.Monotonic());
  clock_.Advance(milliseconds(299));
  EXPECT_EQ(reader.Look("bench-1").value(), first);
  clock_.Advance(milliseconds(1));
  EXPECT_EQ(reader.Look("bench-1").value()->bytes, CameraSite::Picture(2));
  EXPECT_EQ(site_.asked(), 2);
  EXPECT_EQ(reader.Look("bench-2").value()->bytes, CameraSite::Picture(1)) << "its own camera";
}

TEST_F(CameraReaderTest, AMomentGetsNoPictureFromBeforeIt) {
  CameraReader reader = Reader();
  ASSERT_TRUE(reader.Look("bench-1").ok());
  clock_.Advance(milliseconds(10));
  EXPECT_EQ(reader.Look("bench-1", clock_.Monotonic()).value()->bytes, CameraSite::Picture(2));
  EXPECT_EQ(reader.Look("bench-1", clock_.Monotonic()).value()->bytes, CameraSite::Picture(2));
}

TEST_F(CameraReaderTest, AllWhoLookWhileACameraIsAskedGetItsAnswer) {
  CameraReader reader = Reader();
  site_.Close();
  std::vector<std::thread> viewers;
  std::vector<std::string> seen(8);
  for (std::string& mine : seen) {
    viewers.emplace_back([&] { mine = reader.Look("bench-1").value()->bytes; });
  }
  site_.WaitForAsked(1);
  site_.Open();
  for (std::thread& viewer : viewers) viewer.join();
  EXPECT_THAT(seen, testing::Each(CameraSite::Picture(1)));
  EXPECT_EQ(site_.asked(), 1);
}

TEST_F(CameraReaderTest, ASilentCameraIsGivenUpAndNotAskedAgainAtOnce) {
  CameraReader reader = Reader({}, milliseconds(1000));
  site_.Close();
  EXPECT_THAT(Failure(reader), HasSubstr("does not answer"));
  EXPECT_THAT(Failure(reader), HasSubstr("does not answer"));
  EXPECT_EQ(site_.asked(), 1) << "nobody waits for it a second time";
  site_.Open();
  clock_.Advance(milliseconds(10));
  EXPECT_EQ(Failure(reader), "The camera does not answer.");
  EXPECT_TRUE(reader.Look("bench-1", clock_.Monotonic()).ok()) << "a moment is asked for at once";
  EXPECT_THAT(log_, ElementsAre(HasSubstr("does not answer"), HasSubstr("works again")));
}

TEST_F(CameraReaderTest, ACameraThatFailedIsAskedAgainAfterAPause) {
  CameraReader reader = Reader();
  site_.Answers("no picture");
  EXPECT_NE(Failure(reader), "a picture");
  site_.Answers("");
  clock_.Advance(milliseconds(999));
  EXPECT_NE(Failure(reader), "a picture");
  clock_.Advance(milliseconds(1));
  EXPECT_EQ(Failure(reader), "a picture");
}

TEST_F(CameraReaderTest, WhatIsNoPictureIsRefused) {
  CameraReader reader = Reader({.pause = milliseconds(0)});
  const auto says = [&](const std::string& body, int status = 200) {
    site_.Answers(body, status);
    clock_.Advance(milliseconds(300));
    return Failure(reader);
  };
  EXPECT_THAT(says("<html>hello</html>"), HasSubstr("neither JPEG nor PNG"));
  EXPECT_THAT(says("\xFF\xD8"), HasSubstr("neither JPEG nor PNG"));
  EXPECT_THAT(says(CameraSite::Picture(7), 503), HasSubstr("status 503"));
  EXPECT_THAT(says(CameraSite::Picture(7), 302), HasSubstr("status 302")) << "no redirects";
  EXPECT_EQ(says("\x89PNG\r\n\x1A\n.."), "a picture");
  EXPECT_EQ(reader.Look("bench-1").value()->content_type, "image/png");
}

TEST_F(CameraReaderTest, APictureOfMoreThanTwoMegabytesIsRefused) {
  CameraReader reader = Reader({.pause = milliseconds(0)});
  std::string large = CameraSite::Picture(1);
  large.resize(2 << 20);
  site_.Answers(large);
  EXPECT_EQ(reader.Look("bench-1").value()->bytes.size(), 2u << 20);
  clock_.Advance(milliseconds(300));
  site_.Answers(large + "x");
  EXPECT_THAT(Failure(reader), HasSubstr("too large"));
}

TEST(CameraAddress, IsHttpsOrInTheLocalNetwork) {
  for (const char* good : {"http://127.0.0.1:8080/snapshot",
                           "http://localhost/snapshot",
                           "http://10.1.2.3/s",
                           "http://172.31.0.1/s",
                           "http://192.168.1.20:8080/s?a=b",
                           "http://[::1]:8080/s",
                           "http://[fd00::7]/s",
                           "http://camera.local/s",
                           "https://cameras.example.org/s"}) {
    EXPECT_TRUE(CameraReader::CheckAddress(good).ok()) << good;
  }
  for (const char* bad : {"",
                          "snapshot",
                          "http://8.8.8.8/s",
                          "http://172.32.0.1/s",
                          "http://169.254.169.254/latest",
                          "http://[2001:db8::1]/s",
                          "http://example.org/s",
                          "http://127.0.0.1.example.org/s",
                          "http://user:word@127.0.0.1/s",
                          "ftp://127.0.0.1/s",
                          "file:///etc/passwd"}) {
    EXPECT_FALSE(CameraReader::CheckAddress(bad).ok()) << bad;
  }
}

}  // namespace
}  // namespace faultlab::server
