// What viewers received during a run, what they receive when its recording is replayed, and what is
// computed from the recording later are the same bits.
#include "hardware/replay_rig.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <map>
#include <memory>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "server/experiment/recordings.h"
#include "server/net/http_server.h"
#include "server/net/router.h"
#include "tests/paper_rig.h"
#include "tests/server/run/run_fixture.h"
#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

using tests::WebSocketClient;

/// All numbers of a frame, as bits: NaN equals NaN, 0 differs from -0.
std::vector<std::uint64_t> BitsOf(const core::Frame& frame) {
  std::vector<std::uint64_t> bits = {static_cast<std::uint64_t>(frame.sample.index)};
  const auto add = [&bits](double value) { bits.push_back(std::bit_cast<std::uint64_t>(value)); };
  const core::Sample& sample = frame.sample;
  for (const double value :
       {sample.t_s, sample.uc_v, sample.um_v, sample.ua_v, sample.ia_a, sample.n_rpm}) {
    add(value);
  }
  for (const auto& estimate : frame.estimates) {
    bits.push_back(static_cast<std::uint64_t>(estimate.status));
    if (estimate.status == core::EstimateStatus::kInvalid) continue;
    for (const double value : estimate.theta) add(value);
    for (const double value : estimate.sigma) add(value);
    add(estimate.sse);
  }
  return bits;
}

/// Keeps the frames of the runs, as the run's thread made them.
class FrameTap : public RunTap {
 public:
  using Frames = std::vector<std::vector<std::uint64_t>>;
  std::unique_ptr<RunTapStream> Open(const std::string& /*rig*/,
                                     const std::string& run,
                                     hardware::Epoch /*epoch*/) override {
    class Stream : public RunTapStream {
     public:
      explicit Stream(Frames& frames) : frames_(frames) {}
      void OnFrame(const core::Frame& frame) override { frames_.push_back(BitsOf(frame)); }
      void OnEvent(const hardware::RigEvent& /*event*/, double /*t_s*/) override {}

     private:
      Frames& frames_;
    };
    return std::make_unique<Stream>(frames_[run]);
  }
  /// After the run's end.
  const Frames& Of(const std::string& run) { return frames_[run]; }

 private:
  std::map<std::string, Frames> frames_;
};

/// The samples of frame messages, each as the bytes that went over the wire.
using WireRows = std::vector<std::string>;

void AddRows(const std::string& message, WireRows& rows) {
  std::uint16_t count = 0;
  std::uint32_t first = 0;
  std::memcpy(&count, message.data() + 2, sizeof count);
  std::memcpy(&first, message.data() + 4, sizeof first);
  // A frame from before the hub received `resume`. That nothing is left out is asserted at the end.
  if (first > rows.size()) return;
  rows.resize(first);  // a "resume" that comes late is answered from its sample on
  const std::size_t values = kChannelCount * sizeof(float);
  const std::size_t statuses = kFrameHeaderBytes + count * values;
  ASSERT_EQ(message.size(), kFrameHeaderBytes + count * kRowBytes);
  for (std::size_t i = 0; i < count; ++i) {
    rows.push_back(message.substr(kFrameHeaderBytes + i * values, values) +
                   message.substr(statuses + i * kStatusBytes, kStatusBytes));
  }
}

class ReplayTest : public tests::RunFixture {
 protected:
  ReplayTest() {
    manager_->SetTap(&tap_);
    HttpServerOptions http;
    http.listen = "127.0.0.1:0";
    server_ = std::make_unique<HttpServer>(
        http, router_, [this](const HttpRequest& request) -> UpgradeDecision {
          return [this, run = request.Query("run").value_or("")](UpgradedSocket socket) {
            hub_->Adopt(std::move(socket), run, {}, false);
          };
        });
    EXPECT_TRUE(server_->Start().ok());
  }
  ~ReplayTest() override { manager_.reset(); }

  struct Seen {
    RunRecord record;
    WireRows rows;  ///< what a viewer was sent
  };
  /// Runs to the end while a viewer watches.
  Seen Watch(RunRequest request) {
    Seen seen;
    const auto started = manager_->Start(std::move(request));
    EXPECT_TRUE(started.ok()) << started.error().message;
    const std::string id = started.value().id;
    WebSocketClient viewer(server_->port(), "/ws?run=" + id);
    viewer.SendText(R"({"type":"resume","since":0})");
    manager_->Wait(id);
    seen.record = store_->Get(id).value();
    const auto samples = static_cast<std::size_t>(seen.record.samples);
    while (seen.rows.size() < samples && !HasFatalFailure()) {
      const auto frame = viewer.Read();
      EXPECT_TRUE(frame) << "the hub ended after " << seen.rows.size() << " of " << samples;
      if (!frame) break;
      if (frame->opcode == 2) AddRows(frame->payload, seen.rows);
    }
    return seen;
  }

  FrameTap tap_;
  Router router_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(ReplayTest, ShowsTheBitsThatLiveViewersSaw) {
  const Seen live = Watch(Paper());
  ASSERT_EQ(live.record.state, RunState::kFinished) << log_;
  ASSERT_EQ(live.rows.size(), 2000u);
  const auto samples = store_->LoadSamples(live.record.id, 0, 5000).value();

  hardware::ReplayRigOptions options;
  options.bench = &paper::Bench();
  options.speed = 0.0;
  RunRequest request;
  request.diagnosis = paper::Options();
  request.owner = "guest";
  request.plan = hardware::ReplayPlan(live.record.period_s);
  request.hold = RigHandle(hardware::MakeReplayRig(samples, options));
  const Seen replayed = Watch(std::move(request));
  EXPECT_EQ(replayed.record.state, RunState::kFinished) << log_;

  FrameTap::Frames computed;
  WireRows computed_rows;
  core::ReplayEstimates(
      samples, OptionsOf(live.record, paper::Bench()).value(), [&](const core::Frame& frame) {
        computed.push_back(BitsOf(frame));
        const StreamRow row = MakeRow(frame);
        AddRows(EncodeFrameMessage({&row, 1}, frame.sample.index, 0.0), computed_rows);
      });

  const FrameTap::Frames& made = tap_.Of(live.record.id);
  const FrameTap::Frames& made_again = tap_.Of(replayed.record.id);
  ASSERT_EQ(made.size(), live.rows.size());
  ASSERT_EQ(made_again.size(), made.size());
  ASSERT_EQ(computed.size(), made.size());
  ASSERT_EQ(replayed.rows.size(), made.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    ASSERT_EQ(made[i], computed[i]) << "sample " << i << ", live and computed";
    ASSERT_EQ(made[i], made_again[i]) << "sample " << i << ", live and replayed";
    ASSERT_EQ(live.rows[i], computed_rows[i]) << "sample " << i << ", seen and computed";
    ASSERT_EQ(live.rows[i], replayed.rows[i]) << "sample " << i << ", seen live and in the replay";
  }
}

}  // namespace
}  // namespace faultlab::server
