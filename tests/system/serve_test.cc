// A complete server in this process, used over its sockets.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

#include "server/app/application.h"
#include "server/csv/file_io.h"
#include "server/storage/database.h"
#include "tests/support/json_schema.h"
#include "tests/support/paths.h"
#include "tests/support/raw_client.h"
#include "tests/support/temp_folder.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;
using tests::WebSocketClient;

constexpr const char* kPaper =
    R"({"name":"R1 = 100","duration_s":20,"faults":[{"component":"R1","value":100,"at_s":10}]})";

std::string ReadText(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

class ServeTest : public ::testing::Test {
 protected:
  ServeTest() : description_(ReadText(tests::InSource("server/api/openapi.json"))) {
    config_.listen = "127.0.0.1:0";
    config_.data_dir = folder_.File("data");
    config_.sim_speed = 40.0;
    config_.fixture_seed = 1;
    Open();
  }
  void Open() {
    auto opened = Application::Open(config_);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    application_ = std::move(opened).value();
  }
  int port() const { return application_->port(); }

  /// Sends a request and checks the answer against the API's description.
  HttpAnswer Call(const std::string& method,
                  const std::string& pattern,
                  const std::string& target,
                  const std::string& body = {},
                  const std::string& content_type = "application/json") {
    const std::string headers =
        method == "POST" ? "Content-Type: " + content_type + "\r\n" : std::string();
    HttpAnswer answer = tests::Request(port(), method, target, headers, body);
    const auto error = description_.CheckAnswer(
        method, pattern, answer.status, answer.Header("Content-Type"), answer.body);
    EXPECT_FALSE(error) << *error;
    return answer;
  }
  HttpAnswer CallRun(const std::string& method, const std::string& rest, const std::string& id) {
    const std::string pattern = "/api/v1/runs/{id}";
    return Call(method, pattern + rest.substr(0, rest.find('?')), "/api/v1/runs/" + id + rest);
  }
  std::string StartRun(const std::string& body) {
    const auto wrong = description_.CheckRequest("POST", "/api/v1/runs", body);
    EXPECT_FALSE(wrong) << *wrong;
    const HttpAnswer answer = Call("POST", "/api/v1/runs", "/api/v1/runs", body);
    EXPECT_EQ(answer.status, 201) << answer.body;
    return std::string(json::parse(answer.body).at("id").as_string());
  }
  std::string Finished(const std::string& body) {
    const std::string id = StartRun(body);
    application_->runs().Wait(id);
    return id;
  }
  std::unique_ptr<WebSocketClient> Watch(const std::string& id) {
    const HttpAnswer token = CallRun("POST", "/stream-token", id);
    EXPECT_EQ(token.status, 201);
    const std::string code(json::parse(token.body).at("code").as_string());
    auto client = std::make_unique<WebSocketClient>(port(), "/ws?code=" + code);
    EXPECT_EQ(client->status(), 101);
    return client;
  }
  static json::object Object(const HttpAnswer& answer) {
    return json::parse(answer.body).as_object();
  }

  tests::TempFolder folder_;
  tests::ApiDescription description_;
  Config config_;
  std::unique_ptr<Application> application_;
};

TEST_F(ServeTest, GoesFromARequestToTheStreamTheRecordingAndThePlot) {
  const std::string id = StartRun(kPaper);
  auto viewer = Watch(id);
  const auto hello = viewer->ReadTextWith("\"hello\"");
  ASSERT_TRUE(hello);
  const json::object greeting = json::parse(*hello).as_object();
  EXPECT_EQ(greeting.at("run"), json::value(id));
  EXPECT_EQ(greeting.at("channels").as_array().size(), 23u);
  EXPECT_TRUE(greeting.at("can_command").as_bool());
  EXPECT_EQ(greeting.at("plan").at("faults").at(0).at("component"), "R1");
  viewer->SendText(R"({"type":"resume","since":0})");

  std::uint32_t next = 0;
  bool resumed = false;
  std::vector<std::string> kinds;
  for (const auto& event : greeting.at("events").as_array()) {
    kinds.emplace_back(event.at("kind").as_string());
  }
  json::object verdict;
  std::string state;
  std::string live_frames;
  while (state.empty() || next < 2000) {
    const auto frame = viewer->Read();
    ASSERT_TRUE(frame) << "closed at sample " << next;
    if (frame->opcode == 2) {
      std::uint16_t count = 0;
      std::uint32_t first = 0;
      std::memcpy(&count, frame->payload.data() + 2, 2);
      std::memcpy(&first, frame->payload.data() + 4, 4);
      // Live frames may have come before the hub received `resume`; after its answer no frame
      // repeats.
      if (first == 0 && next > 0 && !resumed) {
        resumed = true;
        next = 0;
      }
      if (first > next && !resumed) continue;
      ASSERT_EQ(first, next) << "no sample is missing or repeated";
      next += count;
      continue;
    }
    ASSERT_EQ(frame->opcode, 1);
    const json::object message = json::parse(frame->payload).as_object();
    if (message.at("type") == "event") kinds.emplace_back(message.at("kind").as_string());
    if (message.at("type") == "verdict") verdict = message;
    if (message.at("type") == "end") state = std::string(message.at("state").as_string());
  }
  EXPECT_EQ(state, "finished");
  EXPECT_EQ(next, 2000u);
  for (const char* kind : {"started", "fault_commanded", "relay_confirmed", "detected"}) {
    EXPECT_EQ(std::count(kinds.begin(), kinds.end(), kind), 1) << kind;
  }
  EXPECT_EQ(verdict.at("verdict"), "fault");
  EXPECT_EQ(verdict.at("candidates").at(0).at("component"), "R1");
  EXPECT_FALSE(verdict.at("path").as_array().empty());

  const json::object run = Object(CallRun("GET", "", id));
  EXPECT_EQ(run.at("state"), "finished");
  EXPECT_EQ(run.at("samples"), 2000);
  EXPECT_EQ(run.at("verdict"), "fault");
  const HttpAnswer png = CallRun("GET", "/plots/{figure}.png", id);
  EXPECT_EQ(png.status, 404) << "the pattern itself is no figure";
  for (const char* figure : {"signals", "swa", "sia", "models", "friction", "steps", "decisions"}) {
    const HttpAnswer plot = Call("GET",
                                 "/api/v1/runs/{id}/plots/{figure}.png",
                                 "/api/v1/runs/" + id + "/plots/" + figure + ".png");
    EXPECT_EQ(plot.status, 200) << figure;
    EXPECT_EQ(plot.body.substr(1, 3), "PNG") << figure;
  }
}

TEST_F(ServeTest, AnswersEveryReadOfARunAsItsDescriptionSays) {
  const std::string id = Finished(kPaper);
  const json::object samples = Object(CallRun("GET", "/samples?from=100&to=150", id));
  EXPECT_EQ(samples.at("um_v").as_array().size(), 50u);
  EXPECT_EQ(samples.at("index").at(0), 100);
  const json::object estimates = Object(CallRun("GET", "/estimates?estimator=swa_100", id));
  EXPECT_EQ(estimates.at("b0d").as_array().size(), 2000u);
  EXPECT_NEAR(estimates.at("b0d").at(900).to_number<double>(), 2.11, 0.3);
  const json::object diagnosis = Object(CallRun("GET", "/diagnosis", id));
  EXPECT_EQ(diagnosis.at("verdict"), "fault");
  EXPECT_TRUE(diagnosis.at("fit_percent").as_object().size() >= 3) << "with the models' fits";
  EXPECT_GE(Object(CallRun("GET", "/events", id)).at("items").as_array().size(), 5u);
  EXPECT_EQ(Object(Call("GET",
                        "/api/v1/runs/{id}/figures/{figure}",
                        "/api/v1/runs/" + id + "/figures/signals"))
                .at("panels")
                .as_array()
                .empty(),
            false);
  const HttpAnswer csv = CallRun("GET", "/export.csv", id);
  EXPECT_NE(csv.body.find("t_s,uc_v,um_v"), std::string::npos);
  const std::string named(csv.Header("Content-Disposition"));
  EXPECT_TRUE(named.starts_with("attachment; filename=\"20")) << named;
  EXPECT_NE(named.find("_samples.csv\""), std::string::npos) << named;
  EXPECT_TRUE(CallRun("GET", "/export.mat", id).body.starts_with("MATLAB 5.0 MAT-file"));
  EXPECT_EQ(Object(CallRun("GET", "/export.json", id)).at("um_v").as_array().size(), 2000u);
  const json::object page = Object(Call("GET", "/api/v1/runs", "/api/v1/runs?limit=5"));
  EXPECT_EQ(page.at("items").as_array().size(), 1u);
  EXPECT_EQ(Object(Call("GET", "/api/v1/rigs", "/api/v1/rigs")).at("items").as_array().size(), 4u);
  EXPECT_EQ(Object(Call("GET", "/api/v1/auth/me", "/api/v1/auth/me")).at("role"), "guest");
  EXPECT_EQ(Call("GET", "/healthz", "/healthz").status, 200);
  EXPECT_EQ(Call("GET", "/readyz", "/readyz").status, 200);
  const HttpAnswer metrics = Call("GET", "/metrics", "/metrics");
  EXPECT_NE(metrics.body.find("faultlab_runs_ended_total{state=\"finished\"} 1\n"),
            std::string::npos);
  EXPECT_NE(metrics.body.find("# TYPE faultlab_rig_lateness_seconds histogram\n"),
            std::string::npos);
  EXPECT_NE(metrics.body.find("faultlab_rig_lateness_seconds_count{rig=\"sim-1\"} 4"),
            std::string::npos)
      << "two wake-ups a sample";
  const json::object run = Object(CallRun("GET", "", id));
  EXPECT_GE(run.at("loop").at("ticks").to_number<int>(), 4000);
  EXPECT_EQ(Object(CallRun("GET", "/export.json", id)).at("loop"), run.at("loop"));
  EXPECT_NE(csv.body.find("# loop {\"ticks\":"), std::string::npos);
  EXPECT_EQ(Call("GET", "/api/v1/openapi.json", "/api/v1/openapi.json").status, 200);
}

TEST_F(ServeTest, ReviewsARunByTheFramesOfTheLiveView) {
  const std::string id = Finished(R"({"duration_s":3})");
  const HttpAnswer frames = CallRun("GET", "/frames?from=250", id);
  ASSERT_EQ(frames.status, 200);
  std::size_t at = 0;
  std::uint32_t next = 250;
  while (at < frames.body.size()) {
    std::uint32_t size = 0;
    std::uint16_t count = 0;
    std::uint32_t first = 0;
    std::memcpy(&size, frames.body.data() + at, 4);
    std::memcpy(&count, frames.body.data() + at + 6, 2);
    std::memcpy(&first, frames.body.data() + at + 8, 4);
    EXPECT_EQ(first, next);
    EXPECT_EQ(size, 16u + count * 100u);
    next += count;
    at += 4 + size;
  }
  EXPECT_EQ(next, 300u);
  EXPECT_EQ(at, frames.body.size());
}

TEST_F(ServeTest, RefusesBadPlansByFieldAndStartsNothing) {
  const struct {
    const char* body;
    const char* field;
  } cases[] = {
      {R"({"excitation":{"kind":"prbs","high_v":30}})", "/excitation/high_v"},
      {R"({"faults":[{"component":"R99","value":1}]})", "/faults/0/component"},
      {R"({"period_s":0})", "/period_s"},
      {R"({"duration_s":3600})", "/duration_s"},
      {R"({"rig":"bench-9"})", "/rig"},
      {R"({"recording":"rec-nothing"})", "/recording"},
      {R"({"surprise":1})", "/surprise"},
  };
  for (const auto& bad : cases) {
    const HttpAnswer answer = Call("POST", "/api/v1/runs", "/api/v1/runs", bad.body);
    EXPECT_TRUE(answer.status == 400 || answer.status == 404) << bad.body;
    EXPECT_EQ(Object(answer).at("field"), bad.field) << answer.body;
  }
  EXPECT_EQ(Call("POST", "/api/v1/runs", "/api/v1/runs", "{}", "text/plain").status, 415);
  EXPECT_TRUE(application_->runs().Running().empty());
}

TEST_F(ServeTest, RefusesUnknownThingsAndParameters) {
  EXPECT_EQ(CallRun("GET", "", "run-nothing").status, 404);
  const std::string id = Finished(R"({"duration_s":1})");
  EXPECT_EQ(CallRun("GET", "/estimates?estimator=kalman", id).status, 400);
  EXPECT_EQ(CallRun("GET", "/samples?form=1", id).status, 400);
  EXPECT_EQ(CallRun("GET", "/samples?from=-1", id).status, 400);
  EXPECT_EQ(Call("GET", "/api/v1/runs", "/api/v1/runs?cursor=forged").status, 400);
  EXPECT_EQ(CallRun("POST", "/stop", id).status, 409);
  EXPECT_EQ(tests::Get(port(), "/api/v1/nothing").status, 404);
}

TEST_F(ServeTest, KeepsRecordingsOverARestart) {
  const std::string id = Finished(R"({"duration_s":2})");
  const std::string before = CallRun("GET", "/samples", id).body;
  application_.reset();
  Open();
  EXPECT_EQ(CallRun("GET", "/samples", id).body, before);
  EXPECT_EQ(Object(CallRun("GET", "", id)).at("state"), "finished");
}

TEST_F(ServeTest, KeepsWhatEachRunLearntAboutItsRig) {
  const auto calibrations = [&](const std::string& rig) {
    return Object(Call("GET",
                       "/api/v1/rigs/{id}/calibrations",
                       "/api/v1/rigs/" + rig + "/calibrations"))
        .at("items")
        .as_array();
  };
  EXPECT_TRUE(calibrations("sim-1").empty());
  const std::string id = Finished(R"({"rig":"sim-1","duration_s":8})");
  ASSERT_EQ(calibrations("sim-1").size(), 1u);
  const json::object item = calibrations("sim-1")[0].as_object();
  EXPECT_EQ(item.at("run"), json::value(id));
  EXPECT_EQ(item.at("calibration").at("dated"), item.at("at"));
  EXPECT_NEAR(item.at("calibration").at("delta_s").to_number<double>(), 9.5e-3, 1e-4);
  EXPECT_NEAR(item.at("calibration").at("nominal").at("R1").to_number<double>(), 1.0, 0.1);
  Finished(R"({"recording":")" + id + R"("})");
  EXPECT_EQ(calibrations("sim-1").size(), 1u) << "a replay teaches nothing about a rig";
  EXPECT_TRUE(calibrations("sim-2").empty());
  application_.reset();
  Open();
  EXPECT_EQ(calibrations("sim-1").size(), 1u) << "and it is there after a restart";
}

TEST_F(ServeTest, MarksARunThatACrashCutOff) {
  RunRecord record;
  record.id = "run-cut";
  record.owner = "guest";
  record.source = "run";
  record.server_id = config_.server_id;
  record.created_at = SystemClock().Wall();
  ASSERT_TRUE(application_->store().Begin(record).ok());
  std::vector<core::Sample> samples(100);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].index = static_cast<int>(i);
  ASSERT_TRUE(application_->store().AppendChunk("run-cut", 0, samples).ok());
  application_.reset();
  Open();
  const json::object run = Object(CallRun("GET", "", "run-cut"));
  EXPECT_EQ(run.at("state"), "interrupted");
  EXPECT_EQ(run.at("samples"), 100);
  EXPECT_EQ(CallRun("GET", "/diagnosis", "run-cut").status, 200);
}

TEST_F(ServeTest, ASecondServerOnTheSameFolderIsRefusedBeforeItTouchesARun) {
  config_.sim_speed = 1.0;
  application_.reset();
  Open();
  const std::string id = StartRun("{}");
  const auto second = Application::Open(config_);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, core::ErrorCode::kConflict);
  EXPECT_NE(second.error().message.find("process " + std::to_string(getpid())), std::string::npos)
      << second.error().message;
  EXPECT_EQ(application_->store().Get(id).value().state, RunState::kRunning);
  EXPECT_EQ(Object(CallRun("GET", "", id)).at("state"), "running");
  EXPECT_EQ(CallRun("POST", "/stop", id).status, 202);
}

TEST_F(ServeTest, AServerWithoutItsPortMarksNothing) {
  RunRecord record;
  record.id = "run-elsewhere";
  record.source = "run";
  record.server_id = config_.server_id;
  ASSERT_TRUE(application_->store().Begin(record).ok());
  application_.reset();
  Config other = config_;
  other.data_dir = folder_.File("other");
  auto holder = Application::Open(other);
  ASSERT_TRUE(holder.ok());
  config_.listen = holder.value()->address();
  const auto refused = Application::Open(config_);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kUnavailable) << refused.error().message;
  auto database = Database::Open({.location = config_.data_dir + "/faultlab.db"}).value();
  EXPECT_EQ(RecordingStore(*database).Get("run-elsewhere").value().state, RunState::kRunning);
}

TEST_F(ServeTest, StopsARunOnRequestAndByASocketsCommand) {
  config_.sim_speed = 1.0;
  application_.reset();
  Open();
  const std::string first = StartRun("{}");
  EXPECT_EQ(CallRun("POST", "/stop", first).status, 202);
  application_->runs().Wait(first);
  EXPECT_EQ(Object(CallRun("GET", "", first)).at("state"), "stopped");

  const std::string second = StartRun("{}");
  auto viewer = Watch(second);
  const auto hello = viewer->ReadTextWith("\"hello\"");
  ASSERT_TRUE(hello);
  const std::string epoch = json::serialize(json::parse(*hello).at("epoch"));
  const std::string command = R"({"type":"command","id":"1","action":"stop","epoch":)";
  viewer->SendText(command + "99999}");
  const auto stale = viewer->ReadTextWith("\"ack\"");
  ASSERT_TRUE(stale);
  EXPECT_NE(stale->find("stale"), std::string::npos);
  viewer->SendText(command + epoch + "}");
  EXPECT_EQ(viewer->ReadTextWith("\"ack\""), R"({"type":"ack","id":"1","ok":true})");
  const auto end = viewer->ReadTextWith("\"end\"");
  EXPECT_EQ(end, R"({"type":"end","state":"stopped"})");
}

TEST_F(ServeTest, FollowsALiveCommandToTheRelay) {
  config_.sim_speed = 1.0;
  application_.reset();
  Open();
  const std::string id = StartRun("{}");
  auto viewer = Watch(id);
  const auto hello = viewer->ReadTextWith("\"hello\"");
  ASSERT_TRUE(hello);
  const std::string epoch = json::serialize(json::parse(*hello).at("epoch"));
  viewer->SendText(R"({"type":"command","id":"5","action":"set","component":"R1","value":56,)"
                   R"("epoch":)" +
                   epoch + "}");
  const auto confirmed = viewer->ReadTextWith("relay_confirmed");
  ASSERT_TRUE(confirmed);
  const json::object event = json::parse(*confirmed).as_object();
  EXPECT_EQ(event.at("component"), "R1");
  EXPECT_EQ(event.at("value").to_number<double>(), 56.0);
  EXPECT_TRUE(application_->runs().Stop(id, "test is over").ok());
}

TEST_F(ServeTest, OpensTheStreamOnceForEachCode) {
  const std::string id = StartRun(R"({"duration_s":5})");
  const HttpAnswer token = CallRun("POST", "/stream-token", id);
  const std::string code(Object(token).at("code").as_string());
  WebSocketClient first(port(), "/ws?code=" + code);
  EXPECT_EQ(first.status(), 101);
  WebSocketClient second(port(), "/ws?code=" + code);
  EXPECT_EQ(second.status(), 403);
  WebSocketClient without(port(), "/ws");
  EXPECT_EQ(without.status(), 403);
}

TEST_F(ServeTest, RecordsTheSameWhileABrowserIsHostile) {
  const std::string plan = R"({"duration_s":100,"seed":3})";  // lasts until its viewers have come
  const std::string quiet = Finished(plan);
  const std::string id = StartRun(plan);
  auto deaf = Watch(id);  // never reads
  auto noisy = Watch(id);
  std::thread noise([&] {
    for (int i = 0; i < 100 && noisy->Send(std::string(1000, '\xff')); ++i) {
    }
  });
  auto good = Watch(id);
  EXPECT_TRUE(good->ReadTextWith("\"end\""));
  noise.join();
  EXPECT_EQ(CallRun("GET", "/samples", id).body, CallRun("GET", "/samples", quiet).body);
}

TEST_F(ServeTest, TakesACsvAndReplaysItThroughTheLiveView) {
  const std::string run = Finished(kPaper);
  const std::string csv = CallRun("GET", "/export.csv", run).body;
  const HttpAnswer uploaded =
      Call("POST", "/api/v1/recordings", "/api/v1/recordings?name=my%20bench", csv, "text/csv");
  ASSERT_EQ(uploaded.status, 201) << uploaded.body;
  const json::object recording = Object(uploaded);
  EXPECT_EQ(recording.at("samples"), 2000);
  EXPECT_EQ(recording.at("verdict"), "fault");
  EXPECT_EQ(recording.at("name"), "my bench");
  const std::string id(recording.at("id").as_string());
  const std::string replay = Finished("{\"recording\":\"" + id + "\"}");
  EXPECT_EQ(Object(CallRun("GET", "", replay)).at("verdict"), "fault");
  const auto um = [&](const std::string& which) {
    return Object(CallRun("GET", "/samples", which)).at("um_v");
  };
  EXPECT_EQ(um(replay), um(run)) << "bit-equal through CSV and replay";
  EXPECT_EQ(
      Object(Call("GET", "/api/v1/recordings", "/api/v1/recordings")).at("items").as_array().size(),
      1u);
}

TEST_F(ServeTest, AnUploadIsDiagnosedAsAskedAndListedAmongTheUploads) {
  const std::string run = Finished(kPaper);
  const std::string csv = CallRun("GET", "/export.csv", run).body;
  const auto upload = [&](const std::string& how, const std::string& body) {
    return Call(
        "POST", "/api/v1/recordings", "/api/v1/recordings?name=mine" + how, body, "text/csv");
  };
  const json::object usual = Object(upload("", csv));
  EXPECT_EQ(usual.at("verdict"), "fault");
  EXPECT_TRUE(usual.at("reason").as_string().starts_with("R1 = ")) << usual.at("reason");

  const json::object longer = Object(upload("&healthy_from_s=1&healthy_to_s=8", csv));
  const auto stretch = [&](const json::object& record) {
    const std::string id(record.at("id").as_string());
    const json::object found = Object(CallRun("GET", "/diagnosis", id));
    return found.at("calibration").at("from_s").to_number<double>();
  };
  EXPECT_EQ(stretch(longer), 1.0);
  const json::object shorter = Object(upload("&healthy_from_s=2&healthy_to_s=2.2", csv));
  EXPECT_EQ(shorter.at("verdict"), "calibrating");
  EXPECT_NE(shorter.at("reason").as_string().find("samples, at least"), std::string::npos)
      << shorter.at("reason");

  const std::string from(usual.at("id").as_string());
  const json::object by_another = Object(upload("&calibration=" + from, csv));
  EXPECT_EQ(by_another.at("verdict"), "fault");
  const auto reason = [&](const std::string& how) {
    const HttpAnswer answer = upload(how, csv);
    EXPECT_EQ(answer.status, 400) << answer.body;
    return std::string(Object(answer).at("reason").as_string());
  };
  const std::string without(shorter.at("id").as_string());
  EXPECT_EQ(reason("&calibration=" + without), "calibration_missing");
  EXPECT_EQ(reason("&healthy_from_s=5&healthy_to_s=4"), "stretch_backwards");
  EXPECT_EQ(reason("&healthy_to_s=soon"), "number_outside");
  EXPECT_EQ(upload("&calibration=nobody", csv).status, 404);
  EXPECT_EQ(upload("&healthy=1:2", csv).status, 400);

  const auto listed = [&](const std::string& query) {
    return Object(Call("GET", "/api/v1/runs", "/api/v1/runs" + query))
        .at("items")
        .as_array()
        .size();
  };
  EXPECT_EQ(listed("?source=upload"), 4u) << "what was refused left nothing";
  EXPECT_EQ(listed(""), 1u);
}

TEST_F(ServeTest, TheUsualStretchOfAnUploadCountsFromItsFirstRow) {
  const std::string csv = CallRun("GET", "/export.csv", Finished(kPaper)).body;
  std::istringstream lines(csv);
  std::string late;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t comma = line.find(',');
    const bool row = !line.empty() && std::isdigit(static_cast<unsigned char>(line.front())) != 0;
    late +=
        row ? std::to_string(std::stod(line.substr(0, comma)) + 40.0) + line.substr(comma) : line;
    late += '\n';
  }
  const json::object recording =
      Object(Call("POST", "/api/v1/recordings", "/api/v1/recordings", late, "text/csv"));
  EXPECT_EQ(recording.at("verdict"), "fault") << recording.at("reason");
  const std::string id(recording.at("id").as_string());
  const json::object found = Object(CallRun("GET", "/diagnosis", id));
  EXPECT_NEAR(found.at("detected_at_s").to_number<double>(), 50.0, 0.2) << "by its own clock";
}

TEST_F(ServeTest, ACalibrationIsForItsBenchAndItsPeriodAlone) {
  const auto upload = [&](const std::string& how, const std::string& body) {
    return Object(
        Call("POST", "/api/v1/recordings", "/api/v1/recordings?name=mine" + how, body, "text/csv"));
  };
  const std::string csv = CallRun("GET", "/export.csv", Finished(kPaper)).body;
  const std::string from(upload("", csv).at("id").as_string());
  std::string slow = "t_s,uc_v,um_v\n";
  for (int i = 0; i < 400; ++i) {
    slow += std::to_string(0.02 * i) + (i % 3 == 0 ? ",3,6\n" : ",2,5\n");
  }
  const json::object refused = upload("&calibration=" + from, slow);
  EXPECT_EQ(refused.at("reason"), "calibration_of_other_period");
  EXPECT_EQ(refused.at("field"), "calibration");
}

TEST_F(ServeTest, TakesACompressedCsv) {
  const std::string csv = CallRun("GET", "/export.csv", Finished(kPaper)).body;
  const auto upload = [&](const std::string& body) {
    return Call("POST", "/api/v1/recordings", "/api/v1/recordings", body, "application/gzip");
  };
  const std::string packed = Gzip(csv);
  const HttpAnswer whole = upload(packed);
  ASSERT_EQ(whole.status, 201) << whole.body;
  EXPECT_EQ(Object(whole).at("samples"), 2000);
  const HttpAnswer unnamed =
      Call("POST", "/api/v1/recordings", "/api/v1/recordings", packed, "text/csv");
  EXPECT_EQ(unnamed.status, 201) << "its first bytes say that it is compressed: " << unnamed.body;
  EXPECT_EQ(upload(packed.substr(0, packed.size() / 2)).status, 400);
  EXPECT_EQ(upload(csv).status, 400);
  EXPECT_EQ(upload(Gzip(std::string(100 << 20, '0'))).status, 413) << "of a small body";
}

TEST_F(ServeTest, NamesAMotorFaultOfAReplayedRecordingThoughNoReplayCanSwitchOne) {
  const std::string run =
      Finished(R"({"faults":[{"component":"Ra","value":30,"at_s":10}],"seed":7})");
  const std::string csv = CallRun("GET", "/export.csv", run).body;
  const json::object recording =
      Object(Call("POST", "/api/v1/recordings", "/api/v1/recordings", csv, "text/csv"));
  const std::string id(recording.at("id").as_string());
  const std::string replay = Finished("{\"recording\":\"" + id + "\"}");
  const json::object live = Object(CallRun("GET", "/diagnosis", replay));
  EXPECT_EQ(live.at("verdict"), "fault");
  EXPECT_EQ(live.at("candidates").at(0).at("component"), "Ra");
  EXPECT_NEAR(live.at("candidates").at(0).at("value").to_number<double>(), 30.0, 1.0);
}

TEST_F(ServeTest, NamesTheColumnOfABadCsv) {
  const auto field = [&](const std::string& csv) {
    const HttpAnswer answer =
        Call("POST", "/api/v1/recordings", "/api/v1/recordings", csv, "text/csv");
    EXPECT_EQ(answer.status, 400) << csv;
    const json::object problem = Object(answer);
    const auto* named = problem.if_contains("field");
    return named == nullptr ? std::string() : std::string(named->as_string());
  };
  EXPECT_EQ(field("t_s,uc_v\n0,1\n0.01,2\n"), "um_v");
  EXPECT_EQ(field("t_s,uc_v,um_v\n0,1,2\n0.01,x,2\n0.02,1,2\n"), "uc_v");
  field("");
  field("\xff\xfe\x00");
}

TEST_F(ServeTest, AStrangersUploadIsRefusedBeforeItsFirstByte) {
  tests::RawClient stranger(port());
  stranger.Send(
      "POST /api/v1/recordings HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/csv\r\n"
      "X-Forwarded-For: 192.0.2.9\r\nContent-Length: 20000000\r\n\r\n");
  EXPECT_EQ(stranger.ReadAnswer().status, 401);
}

TEST_F(ServeTest, ACallerHasTwoLargeDownloadsUnreadAtMost) {
  RunRecord record;
  record.id = "rec-long";
  record.owner = "guest";
  record.source = "upload";
  ASSERT_TRUE(application_->store().Begin(record).ok());
  std::vector<core::Sample> samples(100'000);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double third = static_cast<double>(i) / 3.0;  // many digits, to fill the socket's buffer
    samples[i] = {static_cast<std::int64_t>(i), third, third, third, third, third, third};
  }
  ASSERT_TRUE(application_->store().AppendChunk("rec-long", 0, samples).ok());

  const std::string path = "/api/v1/runs/rec-long/samples";
  const std::string ask = "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  auto first = std::make_unique<tests::RawClient>(port(), 4096);
  tests::RawClient second(port(), 4096);
  for (tests::RawClient* client : {first.get(), &second}) {
    char byte = 0;
    client->Send(ask);
    ASSERT_EQ(recv(client->fd(), &byte, 1, MSG_PEEK), 1) << "the answer is on its way";
  }
  // Of five more, four wait and one is refused, whichever the server met last.
  constexpr int kHangMs = 120'000;
  std::vector<std::unique_ptr<tests::RawClient>> waiting;
  std::vector<pollfd> turns;
  for (int i = 0; i < 5; ++i) {
    waiting.push_back(std::make_unique<tests::RawClient>(port(), 4096));
    waiting.back()->Send(ask);
    turns.push_back({waiting.back()->fd(), POLLIN, 0});
  }
  ASSERT_EQ(poll(turns.data(), turns.size(), kHangMs), 1);
  const auto answered = std::find_if(
      turns.begin(), turns.end(), [](const pollfd& each) { return each.revents != 0; });
  const HttpAnswer refused =
      waiting[static_cast<std::size_t>(answered - turns.begin())]->ReadAnswer();
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(refused.Header("Retry-After"), "2");
  turns.erase(answered);
  EXPECT_EQ(CallRun("GET", "", "rec-long").status, 200) << "small answers go on";
  EXPECT_EQ(poll(turns.data(), turns.size(), 0), 0) << "the others wait";
  first.reset();
  EXPECT_GE(poll(turns.data(), turns.size(), kHangMs), 1) << "one that waited has its turn";
}

TEST_F(ServeTest, RefusesAnUploadOfTwoGigabytesAtOnce) {
  tests::RawClient client(port());
  client.Send(
      "POST /api/v1/recordings HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/csv\r\n"
      "Content-Length: 2147483648\r\n\r\n");
  EXPECT_EQ(client.ReadAnswer().status, 413);
  EXPECT_EQ(tests::Get(port(), "/healthz").status, 200);
}

TEST_F(ServeTest, ServesThePageOrSaysHowToBuildIt) {
  const HttpAnswer page = tests::Get(port(), "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_TRUE(page.Header("Content-Type").starts_with("text/html"));
  EXPECT_NE(page.body.find("faultlab"), std::string::npos);
  EXPECT_EQ(page.Header("Content-Security-Policy").find("unsafe-inline"), std::string::npos);
}

TEST_F(ServeTest, RunsWithALiveTapOnABus) {
  config_.lcm_url = "memq://";
  application_.reset();
  Open();
  const std::string id = Finished(R"({"duration_s":2})");
  EXPECT_EQ(Object(CallRun("GET", "", id)).at("state"), "finished");
}

TEST_F(ServeTest, LetsNoGuestInFromAnotherMachine) {
  const HttpAnswer answer = tests::Get(port(), "/api/v1/rigs", "X-Forwarded-For: 203.0.113.7\r\n");
  EXPECT_EQ(answer.status, 401);
}

TEST_F(ServeTest, ForgetsADeletedRun) {
  const std::string id = Finished(R"({"duration_s":1})");
  EXPECT_EQ(CallRun("DELETE", "", id).status, 204);
  EXPECT_EQ(CallRun("GET", "", id).status, 404);
}

TEST_F(ServeTest, DescribesEveryRouteThatItHas) {
  for (const auto& [path, operations] : description_.document().at("paths").as_object()) {
    for (const auto& [method, operation] : operations.as_object()) {
      std::string target(path);
      for (std::size_t open = 0; (open = target.find('{')) != std::string::npos;) {
        target.replace(open, target.find('}') - open + 1, "none");
      }
      std::string verb(method);
      std::transform(verb.begin(), verb.end(), verb.begin(), ::toupper);
      const HttpAnswer answer = tests::Request(port(), verb, target);
      EXPECT_NE(answer.status, 405) << verb << ' ' << target;
      const bool names_nothing = target.find("none") != std::string::npos;
      EXPECT_TRUE(answer.status != 404 || names_nothing) << verb << ' ' << target;
      EXPECT_LT(answer.status, 500) << verb << ' ' << target;
    }
  }
}

}  // namespace
}  // namespace faultlab::server
