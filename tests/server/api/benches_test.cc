// Several benches in one server, over HTTP: each rig and each recording is read by its own
// description, also when the server has it no more.
#include <gmock/gmock.h>

#include <boost/json.hpp>
#include <fstream>
#include <map>

#include "hardware/bench/benches.h"
#include "tests/server/api/api_world.h"
#include "tests/support/await.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using testing::HasSubstr;
using testing::SizeIs;
using tests::HttpAnswer;

class BenchesTest : public ApiTest {
 protected:
  BenchesTest() { Serve({{"paper", 2, "", 0}, {"servo-motor", 2, "", 0}}); }

  /// Starts the server anew, as if its settings had been changed.
  void Serve(std::vector<BenchSettings> benches) {
    application_.reset();
    config_.lab_benches = 0;
    config_.sim_speed = 0.0;
    config_.benches = std::move(benches);
    auto opened = Application::Open(config_);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    application_ = std::move(opened).value();
  }
  static const core::Bench& Servo() { return *hardware::LoadBench("servo-motor").value(); }
  json::object Get(const std::string& target) { return Ok(Call(kNobody, "GET " + target)); }
  HttpAnswer Post(const std::string& body) { return Call(kNobody, "POST runs", body); }
  std::string RunToEnd(const std::string& body) {
    const std::string id(Ok(Post(body), 201).at("id").as_string());
    EXPECT_TRUE(tests::Await([&] { return Get("runs/" + id).at("state") != "running"; }));
    return id;
  }
  std::string FaultOnServo() {
    return RunToEnd(R"({"rig":"servo-motor-sim-1","duration_s":12,"seed":4,
                        "faults":[{"component":"Ra","value":6.0,"at_s":7}]})");
  }
};

TEST_F(BenchesTest, ListsThemTheUsualOneFirstAndRigsNameTheirs) {
  const json::array items = Get("benches").at("items").as_array();
  ASSERT_THAT(items, SizeIs(2));
  EXPECT_EQ(items[0].at("name"), "paper");
  EXPECT_EQ(items[1].at("name"), "servo-motor");
  EXPECT_EQ(items[1].at("structure").at("name"), "motor-driver");
  EXPECT_EQ(items[1].at("channels").at("um").at("exists"), false);
  EXPECT_EQ(items[1].at("estimated").at("unit"), "A");
  EXPECT_TRUE(items[1].at("published").is_null());
  const json::object rigs = Get("rigs");
  for (const json::value& rig : rigs.at("items").as_array()) {
    const bool servo = rig.at("id").as_string().starts_with("servo-motor-");
    EXPECT_EQ(rig.at("bench"), items[servo ? 1 : 0].at("id"));
    EXPECT_EQ(rig.at("capabilities").at("um"), !servo);
    EXPECT_EQ(rig.at("class"), servo ? "servo-motor-sim" : "bench-sim");
  }
  const HttpAnswer file = Call(kNobody, "GET benches/servo-motor/file");
  EXPECT_EQ(file.body, Servo().text);
}

TEST_F(BenchesTest, ARunIsPlannedAndDiagnosedByTheBenchOfItsRig) {
  const std::string id = FaultOnServo();
  const json::object run = Get("runs/" + id);
  EXPECT_EQ(run.at("state"), "finished");
  EXPECT_EQ(run.at("bench").as_string(), Servo().id);
  EXPECT_EQ(run.at("period_s"), Servo().period_s);
  EXPECT_EQ(run.at("samples"), 6000);
  EXPECT_EQ(run.at("verdict"), "fault");
  const json::object diagnosis = Get("runs/" + id + "/diagnosis");
  const json::value& best = diagnosis.at("candidates").at(0);
  EXPECT_EQ(best.at("component"), "Ra");
  EXPECT_NEAR(best.at("value").to_number<double>(), 6.0, 0.06);
}

TEST_F(BenchesTest, APlanForAnotherBenchIsRefusedByName) {
  const auto refusal = [this](const std::string& body) { return Ok(Post(body), 400); };
  EXPECT_EQ(refusal(R"({"rig":"servo-motor-sim-1",
                        "faults":[{"component":"R1","value":10,"at_s":7}]})")
                .at("reason"),
            "no_component");
  EXPECT_EQ(refusal(R"({"rig":"servo-motor-sim-1","bench":"paper"})").at("reason"), "other_bench");
  EXPECT_EQ(refusal(R"({"rig":"sim-1","faults":[{"component":"Ke","value":0.01,"at_s":7}]})")
                .at("reason"),
            "no_component");
  EXPECT_EQ(Post(R"({"bench":"qube"})").status, 404);
  const std::string any = RunToEnd(R"({"bench":"servo-motor","duration_s":2})");
  EXPECT_THAT(std::string(Get("runs/" + any).at("rig").as_string()), HasSubstr("servo-motor-sim-"));
}

TEST_F(BenchesTest, ARecordingStaysReadableWhenTheServerHasItsBenchNoMore) {
  const std::string id = FaultOnServo();
  const std::string target = "runs/" + id;
  const HttpAnswer before = Call(kNobody, "GET " + target + "/diagnosis");
  Serve({{"paper", 1, "", 0}});
  EXPECT_THAT(Get("benches").at("items").as_array(), SizeIs(2))
      << "the rigs were seen, and may come back";
  EXPECT_EQ(Get(target).at("bench").as_string(), Servo().id);
  EXPECT_EQ(Call(kNobody, "GET " + target + "/diagnosis").body, before.body);
  EXPECT_EQ(Call(kNobody, "GET " + target + "/plots/signals.png").status, 200);
  EXPECT_EQ(Get("benches/" + Servo().id).at("name"), "servo-motor");
}

TEST_F(BenchesTest, AFaultSetIsForOneBench) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const std::string body =
      R"({"name":"magnets","bench":"servo-motor","faults":[{"component":"Ke","value":0.02,"at_s":1}]})";
  const json::object set = Ok(Call(teacher, "POST fault-sets", body), 201);
  EXPECT_EQ(set.at("bench").as_string(), Servo().id);
  const std::string use = R"({"duration_s":2,"fault_set":)" + Id(set) + R"(,"rig":")";
  const auto start = [&](const std::string& rig) {
    return Call(teacher, "POST runs", use + rig + "\"}");
  };
  EXPECT_EQ(start("servo-motor-sim-1").status, 201);
  EXPECT_EQ(Ok(start("sim-1"), 400).at("reason"), "fault_set_of_other_bench");
}

TEST_F(BenchesTest, AnExportNamesTheBenchOfItsRun) {
  const std::string id = RunToEnd(R"({"rig":"servo-motor-sim-1","duration_s":1})");
  const std::string target = "runs/" + id;
  const HttpAnswer csv = Call(kNobody, "GET " + target + "/export.csv");
  EXPECT_THAT(csv.body, HasSubstr("\n# bench servo-motor, id " + Servo().id + "\n"));
  const json::object all = Get(target + "/export.json");
  EXPECT_EQ(all.at("bench").as_string(), Servo().id);
  EXPECT_EQ(all.at("bench_name"), "servo-motor");
}

TEST_F(BenchesTest, AFaultSetForAnOlderDescriptionIsRefused) {
  const Person teacher = Make("teacher", Role::kInstructor);
  std::string text = Servo().text;
  const auto ke = text.find("[[component]]\nsymbol = \"Ke\"");
  ASSERT_NE(ke, std::string::npos);
  text.erase(ke, text.find("[[component]]", ke + 1) - ke);
  const std::string file = (folder_.path() / "changed.toml").string();
  std::ofstream(file) << text;
  Serve({{"paper", 1, "", 0}, {file, 1, "", 0}});
  const std::string now(Get("benches/servo-motor").at("id").as_string());
  ASSERT_NE(now, Servo().id);
  const auto save = [&](const std::string& bench, const std::string& component) {
    const std::string body = R"({"name":"s","bench":")" + bench + R"(","faults":[{"component":")" +
                             component + R"(","value":4.64,"at_s":1}]})";
    return Call(teacher, "POST fault-sets", body);
  };
  for (const std::string component : {"Ke", "Ra"}) {
    const json::object refused = Ok(save(Servo().id, component), 409);
    EXPECT_EQ(refused.at("reason"), "bench_has_changed");
    EXPECT_EQ(refused.at("parameters").at("now").as_string(), now);
  }
  EXPECT_EQ(Ok(save("servo-motor", "Ke"), 400).at("reason"), "no_component");
  EXPECT_EQ(Ok(save(now, "Ra"), 201).at("bench").as_string(), now);
}

TEST_F(BenchesTest, RigsThatTheServerHasNoMoreAreOfflineUntilTheyAreBack) {
  const Person student = Make("student", Role::kStudent);
  using Ready = std::map<std::string, std::int64_t>;
  const auto ready = [this] {
    Ready counts;
    const json::object classes = Get("rig-classes");
    for (const json::value& each : classes.at("items").as_array()) {
      const std::string id = Id(each);
      if (id.ends_with("-sim")) counts[id] = each.at("ready").as_int64();
    }
    return counts;
  };
  EXPECT_EQ(ready(), (Ready{{"bench-sim", 2}, {"servo-motor-sim", 2}}));
  Serve({{"paper", 2, "", 0}});
  EXPECT_EQ(ready(), (Ready{{"bench-sim", 2}, {"servo-motor-sim", 0}}));
  const json::object rig = Get("rigs/servo-motor-sim-1/health");
  EXPECT_EQ(rig.at("status"), "offline");
  EXPECT_EQ(rig.at("reason"), "this server has no such rig now");
  const json::object asked =
      Ok(Call(student, "POST tickets", R"({"rig_class":"servo-motor-sim"})"), 201);
  ASSERT_TRUE(asked.contains("ticket")) << json::serialize(asked);
  EXPECT_EQ(asked.at("ticket").at("state"), "waiting");
  EXPECT_TRUE(asked.at("ticket").at("expected").is_null());
  // The first bench's are "sim-1", ..; the names of the others begin with their bench.
  Serve({{"servo-motor", 2, "", 0}, {"paper", 1, "", 0}});
  EXPECT_EQ(ready(), (Ready{{"bench-sim", 1}, {"servo-motor-sim", 1}})) << "one for the ticket";
  EXPECT_EQ(Get("rigs/sim-1/health").at("rig_class"), "servo-motor-sim");
}

TEST_F(BenchesTest, NoSimulatorOfABenchIsRefusedByTheBenchsName) {
  Serve({{"paper", 1, "", 0}, {"servo-motor", 0, "", 0}});
  const json::object refused = Ok(Post(R"({"bench":"servo-motor"})"), 404);
  EXPECT_EQ(refused.at("reason"), "no_simulator");
  EXPECT_EQ(refused.at("parameters").at("bench"), "servo-motor");
  EXPECT_THAT(Text(refused, "detail"), HasSubstr("of the bench servo-motor"));
}

}  // namespace
}  // namespace faultlab::server
