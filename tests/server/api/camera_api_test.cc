// Pictures of a bench: who sees them, while a run goes on and afterwards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <set>

#include "server/storage/picture_store.h"
#include "tests/server/api/api_world.h"
#include "tests/support/await.h"
#include "tests/support/camera_site.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using std::chrono::milliseconds;
using testing::HasSubstr;
using tests::CameraSite;
using tests::HttpAnswer;

/// Made before the server, which asks it.
struct WithCamera {
  CameraSite camera_;
};

class CameraApiTest : protected WithCamera, public ApiTest {
 protected:
  CameraApiTest()
      : ApiTest(kSystemClock, [this](Config& config) {
          config.cameras = {{"sim-1", camera_.url()}};
        }) {}

  json::object Start(const Person& who, const std::string& body) {
    return Ok(Call(who, "POST runs", body), 201);
  }
  HttpAnswer Look(const Person& who, const std::string& run) {
    return Call(who, "GET runs/" + run + "/camera");
  }
  json::array Pictures(const Person& who, const std::string& run) {
    const HttpAnswer answer = Call(who, "GET runs/" + run + "/pictures");
    return Ok(answer).at("items").as_array();
  }
  HttpAnswer Picture(const Person& who, const std::string& run, const std::string& index) {
    return Call(who, "GET runs/" + run + "/pictures/" + index);
  }
  bool ShowsCamera(const Person& who, const std::string& run) {
    return Ok(Call(who, "GET runs/" + run)).at("camera").as_bool();
  }
  void End(const Person& who, const std::string& run) {
    Call(who, "POST runs/" + run + "/stop", "{}");
    application_->runs().Wait(run);
  }
  /// The reasons for which pictures are in the database, once that of the end is there.
  std::set<std::string> WhysAtTheEnd(const std::string& run) {
    PictureStore store(*database_);
    std::set<std::string> whys;
    EXPECT_TRUE(tests::Await([&] {
      const auto pictures = store.List(run).value();
      for (const StoredPicture& picture : pictures) whys.insert(picture.why);
      return whys.contains("end");
    })) << "no picture of the end";
    return whys;
  }
};

TEST_F(CameraApiTest, WhoMaySeeARunSeesItsBenchWhileItGoesOn) {
  PlayAtSpeed(4.0);
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  const Person teacher = Make("teacher", Role::kInstructor);
  MakeCourse("teacher", "ann");
  const json::object run = Start(ann, R"({"rig":"sim-1","duration_s":600})");
  const std::string id = Id(run);
  EXPECT_TRUE(run.at("camera").as_bool());
  EXPECT_TRUE(ShowsCamera(ann, id));

  const HttpAnswer seen = Look(ann, id);
  ASSERT_EQ(seen.status, 200) << seen.body;
  EXPECT_THAT(seen.body, testing::StartsWith("\xFF\xD8\xFF picture "));
  EXPECT_EQ(seen.Header("Content-Type"), "image/jpeg");
  EXPECT_EQ(seen.Header("Cache-Control"), "no-store");
  const int age_ms = std::stoi(seen.Header("X-Picture-Age-Ms"));
  EXPECT_GE(age_ms, 0);
  EXPECT_LT(age_ms, 120'000) << "of now, and not since 1970";
  EXPECT_EQ(Look(teacher, id).status, 200) << "of a course that ann attends";
  EXPECT_EQ(Look(bob, id).status, 404);
  EXPECT_EQ(Look({}, id).status, 401);

  camera_.Answers("no picture");
  EXPECT_TRUE(tests::Await([&] { return Look(ann, id).status == 503; }))
      << "when the last one is not shared any more";
  EXPECT_TRUE(ShowsCamera(ann, id)) << "it may work again";
  camera_.Answers("");
  End(ann, id);
  EXPECT_FALSE(ShowsCamera(ann, id));
  EXPECT_EQ(Look(ann, id).status, 404);
}

TEST_F(CameraApiTest, ARunWithoutCameraSaysSo) {
  PlayAtSpeed(4.0);
  const Person ann = Make("ann", Role::kStudent);
  const json::object run = Start(ann, R"({"rig":"sim-2","duration_s":600})");
  EXPECT_FALSE(run.at("camera").as_bool());
  EXPECT_EQ(Look(ann, Id(run)).status, 404);
  End(ann, Id(run));
  EXPECT_TRUE(Pictures(ann, Id(run)).empty());
  EXPECT_EQ(camera_.asked(), 0);
}

TEST_F(CameraApiTest, PicturesOfSwitchingDetectionAndEndAreStoredAndGoWithTheRun) {
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  const std::string id = Id(Start(
      ann, R"({"rig":"sim-1","duration_s":8,"faults":[{"component":"R1","value":100,"at_s":6}]})"));
  application_->runs().Wait(id);
  EXPECT_EQ(WhysAtTheEnd(id), (std::set<std::string>{"fault", "detection", "end"}));
  const json::array pictures = Pictures(ann, id);
  ASSERT_FALSE(pictures.empty());
  EXPECT_EQ(pictures[0].at("index"), 1);
  EXPECT_EQ(pictures[0].at("why"), "fault");
  EXPECT_EQ(pictures[0].at("sample"), 600);
  EXPECT_EQ(pictures[0].at("t_s").to_number<double>(), 6.0);
  const HttpAnswer first = Picture(ann, id, "1");
  EXPECT_EQ(first.status, 200);
  EXPECT_EQ(first.Header("Content-Type"), "image/jpeg");
  EXPECT_THAT(first.body, testing::StartsWith("\xFF\xD8\xFF picture "));
  for (const char* wrong : {"0", "12", "13", "-1", "x"}) {
    EXPECT_EQ(Picture(ann, id, wrong).status, 404) << wrong;
  }
  EXPECT_EQ(Picture(bob, id, "1").status, 404);
  EXPECT_EQ(Call(bob, "GET runs/" + id + "/pictures").status, 404);

  EXPECT_EQ(Call(ann, "DELETE runs/" + id).status, 204);
  EXPECT_EQ(Picture(ann, id, "1").status, 404);
  EXPECT_FALSE(PictureStore(*database_).Load(id, 1).ok());
}

TEST_F(CameraApiTest, ARunWithHiddenFaultsLooksAsIfItHadNoCamera) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const std::string hidden = R"({"rig":"sim-1","duration_s":600,"hidden_faults":true,)"
                             R"("faults":[{"component":"R1","value":100,"at_s":6}]})";
  const json::object run = Start(teacher, hidden);
  const std::string id = Id(run);
  EXPECT_FALSE(run.at("camera").as_bool());
  EXPECT_FALSE(ShowsCamera(teacher, id));
  EXPECT_EQ(Look(teacher, id).status, 404);
  EXPECT_EQ(Look(Admin(), id).status, 404);
  End(teacher, id);
  EXPECT_FALSE(WhysAtTheEnd(id).empty());
  EXPECT_TRUE(Pictures(teacher, id).empty());
  EXPECT_EQ(Picture(teacher, id, "1").status, 404);
}

TEST(CameraOfNoRig, IsRefusedAtTheStart) {
  tests::TempFolder folder;
  Config config;
  config.listen = "127.0.0.1:0";
  config.data_dir = folder.File("data");
  config.cameras = {{"sim-1", "http://127.0.0.1:1/s"}, {"bench-9", "http://127.0.0.1:1/s"}};
  const auto opened = Application::Open(config);
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, HasSubstr("no rig 'bench-9'"));
  config.cameras.pop_back();
  EXPECT_TRUE(Application::Open(config).ok());
}

}  // namespace
}  // namespace faultlab::server
