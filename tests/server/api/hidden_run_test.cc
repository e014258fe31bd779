// What the files of a run with hidden faults tell, and to whom.
#include <gtest/gtest.h>

#include <array>
#include <boost/json.hpp>
#include <string>
#include <vector>

#include "tests/server/api/api_world.h"
#include "tests/server/api/secret_search.h"
#include "tests/support/await.h"
#include "tests/support/scale.h"

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
    const json::object run = Ok(Call(ann_, "POST runs", body), 201);
    const std::string id = Id(run);
    application_->runs().Wait(id);
    return id;
  }
  tests::HttpAnswer File(const Person& who,
                         const std::string& run,
                         const std::string& file,
                         const std::string& query = "") {
    return Call(who, "GET runs/" + run + "/" + file + query);
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
       {"export.csv", "export.json", "export.lcm", "export.mat", "export.ipynb", "report.pdf"}) {
    EXPECT_EQ(File(mila_, run, file, "?truth=include").status, 403) << file;
  }
}

TEST_F(HiddenRunTest, NoAnswerOfTheApiTellsItToWhoeverMayNotRead) {
  const Person bob = Make("bob", Role::kStudent);
  const Person colleague = Make("ivo", Role::kInstructor);
  const Person technician = Make("olga", Role::kOperator);
  const json::object started =
      Ok(Call(ann_,
              "POST runs",
              R"({"rig":"sim-1","duration_s":20,"seed":733913557,"hidden_faults":true,"name":"quiz",
               "faults":[{"component":"Ra","value":9.8125,"at_s":12.0625}]})"),
         201);
  const std::string run = Id(started);
  const std::vector<std::string> traces = TracesOf({733913557.0, 9.8125, 12.0625});
  int told_to_owner = 0;
  std::size_t files = 0;
  const auto look = [&] {
    for (const auto& [path, operations] : description_.document().at("paths").as_object()) {
      if (!operations.as_object().contains("get")) continue;
      const std::string target = TargetOf(path, run);
      const auto trace_for = [&](const Person& who) -> std::string {
        const std::string body =
            tests::Request(application_->port(), "GET", target, who.headers).body;
        for (const std::string& trace : traces) {
          if (body.find(trace) != std::string::npos) return trace;
        }
        return {};
      };
      for (const Person& who : {Person{}, bob, colleague}) EXPECT_EQ(trace_for(who), "") << target;
      if (IsFile(target)) {
        const std::array readers = {ann_, mila_, technician};
        for (std::size_t each = 0; each < readers.size(); ++each) {
          // A file is drawn for seconds: each for one of them, unless all is proven.
          if (!tests::Proving() && each != files % readers.size()) continue;
          EXPECT_EQ(trace_for(readers[each]), "") << target;
        }
        ++files;
      } else if (!trace_for(ann_).empty()) {
        ++told_to_owner;
      }
    }
  };
  look();  // while it goes on
  application_->runs().Wait(run);
  told_to_owner = 0;
  look();
  EXPECT_GE(told_to_owner, 3) << "the run, its events and the list: the traces are found";
}

TEST_F(HiddenRunTest, FiguresOfSeveralRunsAreDrawnWithoutIt) {
  // A drift is seen when it has gone some way: not where it was planned.
  const std::string run = Run(R"({"rig":"sim-1","duration_s":14,"hidden_faults":true,
              "faults":[{"component":"R1","value":56,"at_s":6,"kind":"drift","until_s":12}]})");
  const std::string several = "comparison.png?runs=" + run;
  const auto drawn = [&](const Person& who, const std::string& target) {
    return Call(who, "GET " + target);
  };
  const tests::HttpAnswer sealed = drawn(ann_, several);
  EXPECT_EQ(sealed.status, 200);
  EXPECT_TRUE(drawn(mila_, several).body == sealed.body);
  EXPECT_FALSE(drawn(ann_, several + "&truth=include").body == sealed.body)
      << "drawn from the planned change on, not from the estimated one";
  EXPECT_EQ(drawn(mila_, several + "&truth=include").status, 403);

  const json::object batch =
      Ok(Call(ann_, "POST jobs", R"({"name":"b","runs":[)" + std::string(kHidden) + "]}"), 202);
  const std::string id = Text(batch, "batch");
  EXPECT_TRUE(tests::Await([&] {
    const json::object jobs = Ok(Call(ann_, "GET jobs?batch=" + id));
    return jobs.at("items").at(0).at("state") == "finished";
  }));
  for (const std::string file : {"sweep.png", "sweep", "sweep.csv", "curves.png"}) {
    SCOPED_TRACE(file);
    const auto sweep = [&](const Person& who, const std::string& query) {
      return Call(who, "GET jobs/batches/" + id + "/" + file + query);
    };
    EXPECT_EQ(sweep(ann_, "").status, 403);
    EXPECT_EQ(sweep(ann_, "?truth=include").status, 200);
    EXPECT_EQ(sweep(mila_, "?truth=include").status, 403);
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
  SecretNoiseTest() : ApiTest(kSystemClock, [](Config& config) { config.fixture_seed.reset(); }) {}
  json::object Started(const std::string& body) {
    const json::object run = Ok(Call(kNobody, "POST runs", body), 201);
    application_->runs().Wait(Id(run));
    return run;
  }
  std::string Samples(const json::object& run) {
    const std::string id = Id(run);
    return Call(kNobody, "GET runs/" + id + "/samples").body;
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
    return Call(ann, "GET runs?q=" + text).status;
  };
  EXPECT_EQ(search(std::string(100, 'a')), 200);
  EXPECT_EQ(search(std::string(101, 'a')), 400);
}

}  // namespace
}  // namespace faultlab::server
