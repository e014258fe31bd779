// What leaves the server of a blind trial before its release: nothing that tells its truth.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/api/secret_search.h"
#include "tests/server/api/trial_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// Every answer that the API gives anybody, and every byte of the live stream, the student's own
/// included, while it is sealed.
class SealedTrialTest : public TrialTest {
 protected:
  SealedTrialTest() : assignment_(Assign(kRa, R"(,"plan":{"duration_s":600})")) {}

  static void Search(const std::string& body,
                     const std::vector<std::string>& traces,
                     const std::string& where) {
    for (const std::string& trace : traces) {
      EXPECT_EQ(body.find(trace), std::string::npos) << where << " has " << trace;
    }
  }
  /// @param files  also pictures, exports and the report
  void SearchAll(const std::vector<Person>& people,
                 const std::vector<std::string>& traces,
                 bool files) {
    for (const auto& [path, operations] : description_.document().at("paths").as_object()) {
      if (!operations.as_object().contains("get") || path.ends_with("openapi.json")) continue;
      if (IsFile(path) && !files) continue;
      const std::string target = TargetOf(path, run_);
      for (const Person& who : people) {
        Search(
            tests::Request(application_->port(), "GET", target, who.headers).body, traces, target);
      }
    }
  }
  /// The page of the student, which tries to change a component.
  std::unique_ptr<tests::WebSocketClient> Watch() {
    const json::object token = Ok(Call(ann_, "POST runs/" + run_ + "/stream-token", "{}"), 201);
    auto page = std::make_unique<tests::WebSocketClient>(application_->port(),
                                                         "/ws?code=" + Text(token, "code"));
    EXPECT_EQ(page->status(), 101);
    stream_ = page->ReadTextWith("\"hello\"").value_or("{}");
    const json::value hello = json::parse(stream_);
    EXPECT_TRUE(page->SendText(json::serialize(json::object{{"type", "command"},
                                                            {"id", 1},
                                                            {"epoch", hello.at("epoch")},
                                                            {"action", "set"},
                                                            {"component", "R1"},
                                                            {"value", 56}})));
    return page;
  }
  void ReadToItsEnd(tests::WebSocketClient& page) {
    while (const auto frame = page.Read()) {
      stream_ += frame->payload + "\n";
      if (frame->payload.find(R"("type":"end")") != std::string::npos) return;
    }
  }

  std::string stream_;
  const std::int64_t assignment_;
  std::string run_;
};

TEST_F(SealedTrialTest, NoByteTellsItBeforeItsRelease) {
  PlayAtSpeed(4.0);
  const json::object begun = Ok(TryStart(ann_, assignment_), 201);
  const std::int64_t id = begun.at("id").as_int64();
  run_ = begun.at("run").as_string();
  std::string truth;
  const core::Status read = database_->Read([&](Transaction& tx) -> core::Status {
    tx.sql() << "SELECT truth FROM trial WHERE id = " + std::to_string(id), soci::into(truth);
    return core::Done{};
  });
  ASSERT_TRUE(read.ok());
  const json::value parsed = json::parse(truth);
  const double seed = parsed.at("seed").to_number<double>();
  const Person olga = Make("olga", Role::kOperator);
  const auto telling = [](const std::vector<double>& secrets) {
    std::vector<std::string> traces = TracesOf(secrets);
    traces.insert(traces.end(), {"fault_commanded", "relay_confirmed"});
    return traces;
  };
  const std::vector<std::string> traces = telling({seed, 9.8124738261});
  const std::vector<std::string> drawn = telling({seed});
  // Operators and teachers see the pool: of them only what was drawn is hidden.
  const auto page = Watch();
  SearchAll({Person{}, ann_}, traces, false);  // while it goes on
  EXPECT_TRUE(tests::Await([&] {
    return Ok(Call(ann_, "GET runs/" + run_)).at("samples").as_int64() > 1000;
  })) << "the fault has begun";
  EXPECT_EQ(Call(ann_, "POST runs/" + run_ + "/stop", "{}").status, 202);
  ReadToItsEnd(*page);
  EXPECT_GT(stream_.size(), 1000U);
  EXPECT_NE(stream_.find("run_sealed"), std::string::npos) << "a change could find it out";
  Search(stream_, traces, "the live stream");
  application_->runs().Wait(run_);
  SearchAll({Person{}, ann_}, traces, true);
  SearchAll({olga, mila_}, drawn, false);
  ASSERT_EQ(Answer(ann_, id, kRight).status, 200);
  SearchAll({ann_, olga, mila_}, drawn, false);
  MakeDue(assignment_);
  EXPECT_NE(json::serialize(Trial(ann_, id)).find("9.8124738261"), std::string::npos)
      << "and afterwards it does";
}

TEST_F(SealedTrialTest, AStopOverThePageIsInTheAuditLog) {
  PlayAtSpeed(4.0);
  const json::object begun = Ok(TryStart(ann_, assignment_), 201);
  run_ = begun.at("run").as_string();
  const auto page = Watch();
  const json::value hello = json::parse(stream_);
  EXPECT_TRUE(page->SendText(json::serialize(json::object{
      {"type", "command"}, {"id", 2}, {"epoch", hello.at("epoch")}, {"action", "stop"}})));
  application_->runs().Wait(run_);
  const Person admin = Admin();
  EXPECT_TRUE(tests::Await([&] {
    const json::object log = Ok(Call(admin, "GET audit?limit=100"));
    return std::ranges::any_of(log.at("items").as_array(), [&](const json::value& line) {
      return line.at("verb") == "stop_run" && line.at("actor_login") == "ann" &&
             line.at("object").as_string() == "run:" + run_;
    });
  }));
}

/// What a student reads while it is sealed stays true when it is opened: nothing is computed
/// otherwise for them.
TEST_F(SealedTrialTest, TellsNoNumberThatItsReleaseMakesAnotherOne) {
  const std::int64_t exercise = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const std::string run(Play(exercise).at("run").as_string());
  const auto read = [&](const char* route, const std::string& more = "") {
    const tests::HttpAnswer answer = Call(ann_, "GET runs/" + run + "/" + route + more);
    EXPECT_EQ(answer.status, 200) << route;
    return answer.body;
  };
  const auto files = [&] {
    return std::vector<std::string>{read("frames"),
                                    read("samples", "?from=0&to=1400"),
                                    read("export.csv", "?content=estimates")};
  };
  const auto told = [&] { return Ok(Call(ann_, "GET runs/" + run)); };
  const std::vector<std::string> sealed_files = files();
  EXPECT_EQ(Call(ann_, "GET runs/" + run + "/study").status, 409);
  const json::object sealed = told();
  ASSERT_TRUE(sealed.at("plan").as_object().contains("sealed"));
  EXPECT_EQ(sealed.at("story").at("episodes").as_array().size(), 0U);
  MakeDue(exercise);
  const json::object opened = told();
  ASSERT_FALSE(opened.at("plan").as_object().contains("sealed"));
  EXPECT_EQ(opened.at("story").at("episodes").as_array().size(), 1U);
  EXPECT_TRUE(sealed_files == files());
  for (const auto& [name, value] : sealed) {
    if (name == "verdict" || name == "story" || name == "plan" || name == "events") continue;
    const json::value* then = opened.if_contains(name);
    EXPECT_TRUE(then != nullptr && *then == value) << name;
  }
  for (const auto& [name, value] : sealed.at("plan").as_object()) {
    if (name == "sealed" || name == "hidden_faults" || name == "faults") continue;
    const json::value* then = opened.at("plan").as_object().if_contains(name);
    EXPECT_TRUE(then != nullptr && *then == value) << name;
  }
  for (const json::value& event : sealed.at("events").as_array()) {
    EXPECT_NE(std::ranges::find(opened.at("events").as_array(), event),
              opened.at("events").as_array().end())
        << event;
  }
}

}  // namespace
}  // namespace faultlab::server
