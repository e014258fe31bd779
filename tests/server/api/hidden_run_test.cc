// What the files of a run with hidden faults tell, and to whom.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <string>

#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class HiddenRunTest : public ApiTest {
 protected:
  HiddenRunTest() {
    ann_ = Make("ann", Role::kStudent);
    mila_ = Make("mila", Role::kInstructor);
    MakeCourse("mila", "ann");
  }
  std::string Run(const std::string& body) {
    const json::object run = Ok(Call(ann_, "POST", "runs", "runs", body), 201);
    const std::string id(run.at("id").as_string());
    application_->runs().Wait(id);
    return id;
  }
  tests::HttpAnswer File(const Person& who,
                         const std::string& run,
                         const std::string& file,
                         const std::string& query = "") {
    return Call(who, "GET", "runs/{id}/" + file, "runs/" + run + "/" + file + query);
  }

  Person ann_;
  Person mila_;
};

constexpr char kHidden[] = R"({"rig":"sim-1","duration_s":12,"seed":12345,"hidden_faults":true,
                              "faults":[{"component":"R1","value":56,"at_s":8}]})";

TEST_F(HiddenRunTest, ItsFilesLackWhatTellsItsFaults) {
  const std::string run = Run(kHidden);
  for (const std::string file : {"export.csv", "export.json", "export.lcm", "export.mat"}) {
    for (const Person& who : {ann_, mila_}) {
      const tests::HttpAnswer answer = File(who, run, file);
      ASSERT_EQ(answer.status, 200) << file << answer.body;
      for (const char* telling : {"\"seed\":12345",
                                  "fault_commanded",
                                  "relay_confirmed",
                                  "\"at_s\"",
                                  "\"faults\"",
                                  "Do0"}) {
        EXPECT_EQ(answer.body.find(telling), std::string::npos) << file << " has " << telling;
      }
    }
  }
  EXPECT_NE(File(ann_, run, "export.csv").body.find("sealed"), std::string::npos);
  EXPECT_EQ(File(mila_, run, "report.pdf").status, 200);
}

TEST_F(HiddenRunTest, ItsOwnerGetsThemByAskingForTheTruthAndNobodyElse) {
  const std::string run = Run(kHidden);
  const std::string csv = File(ann_, run, "export.csv", "?truth=include").body;
  EXPECT_NE(csv.find("\"seed\":12345"), std::string::npos);
  EXPECT_NE(csv.find("\"component\":\"R1\""), std::string::npos);
  EXPECT_NE(File(ann_, run, "export.json", "?truth=include").body.find("relay_confirmed"),
            std::string::npos);
  for (const std::string file :
       {"export.csv", "export.json", "export.lcm", "export.mat", "report.pdf"}) {
    EXPECT_EQ(File(mila_, run, file, "?truth=include").status, 403) << file;
  }
}

TEST_F(HiddenRunTest, FilesOfOtherRunsTellAll) {
  const std::string run =
      Run(R"({"rig":"sim-1","duration_s":12,"faults":[{"component":"R1","value":56,"at_s":8}]})");
  EXPECT_NE(File(mila_, run, "export.json").body.find("relay_confirmed"), std::string::npos);
}

/// Whoever knows the seed plays the run healthy and finds the first sample that differs.
class SecretNoiseTest : public ApiTest {
 protected:
  SecretNoiseTest() : ApiTest({}, std::nullopt) {}
  json::object Started(const std::string& body) {
    const json::object run = Ok(Call({}, "POST", "runs", "runs", body), 201);
    application_->runs().Wait(std::string(run.at("id").as_string()));
    return run;
  }
  std::string Samples(const json::object& run) {
    const std::string id(run.at("id").as_string());
    return Call({}, "GET", "runs/{id}/samples", "runs/" + id + "/samples").body;
  }
};

TEST_F(SecretNoiseTest, IsAnotherInEachRunUnlessSomebodyAsksForASeed) {
  const std::string plan = R"({"rig":"sim-1","duration_s":2})";
  const json::object one = Started(plan);
  const json::object two = Started(plan);
  EXPECT_NE(one.at("plan").at("seed"), two.at("plan").at("seed"));
  EXPECT_NE(Samples(one), Samples(two));
  const std::string seed = json::serialize(one.at("plan").at("seed"));
  const json::object again = Started(R"({"rig":"sim-1","duration_s":2,"seed":)" + seed + "}");
  EXPECT_EQ(Samples(again), Samples(one)) << "a run can be played again with its seed";
}

TEST_F(ApiTest, ASearchHasAtMostAHundredCharacters) {
  const Person ann = Make("ann", Role::kStudent);
  const auto search = [&](const std::string& text) {
    return Call(ann, "GET", "runs", "runs?q=" + text).status;
  };
  EXPECT_EQ(search(std::string(100, 'a')), 200);
  EXPECT_EQ(search(std::string(101, 'a')), 400);
}

}  // namespace
}  // namespace faultlab::server
