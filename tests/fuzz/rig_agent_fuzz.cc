// Messages from a server to an agent under the right key: the harness seals them. Records of flags
// 1 byte, piece body of a command. A bench that is not running has its drive off, whatever the
// input.
#include <filesystem>

#include "hardware/lcm/channels.h"
#include "hardware/lcm/epoch_file.h"
#include "hardware/lcm/rig_agent.h"
#include "tests/fuzz/sealed_input.h"
#include "tests/paper_bench.h"

using namespace faultlab::hardware;  // NOLINT(google-build-using-namespace)
using faultlab::fuzz::Require;

namespace {

/// Accepts what a rig accepts, and checks it. It has no thread, so that an input takes little time.
class Bench final : public Rig {
 public:
  Bench() {
    description_.id = faultlab::fuzz::kRig;
    description_.bench = &faultlab::paper::Bench();
  }
  const RigDescription& description() const override { return description_; }
  RigState state() const override { return state_; }
  faultlab::core::Status Arm(RunPlan plan, Epoch) override {
    Require(plan.uc_v.size() <= static_cast<std::size_t>(kPlanSamplesMax));
    for (const faultlab::core::Fault& fault : plan.faults) {
      Require(static_cast<int>(fault.kind) >= 0 && static_cast<int>(fault.kind) <= 2);
    }
    state_ = RigState::kArmed;
    return faultlab::core::Done{};
  }
  faultlab::core::Status Start(Epoch) override {
    state_ = RigState::kRunning;
    told_.push_back(faultlab::core::Sample{});
    return faultlab::core::Done{};
  }
  faultlab::core::Status Command(Epoch, const RigCommand& command) override {
    told_.push_back(RigEvent{
        .kind = RigEventKind::kFaultCommanded, .component = command.component, .text = {}});
    return faultlab::core::Done{};
  }
  void KeepAlive(Epoch) override {}
  ReadStatus Read(std::vector<RigMessage>& out, std::chrono::milliseconds) override {
    for (RigMessage& message : told_) out.push_back(std::move(message));
    told_.clear();
    return ReadStatus::kMore;
  }
  void Fence(Epoch) override { state_ = RigState::kIdle; }
  void SafeStop(std::string_view reason) override {
    state_ = RigState::kIdle;
    told_.push_back(RigEvent{.kind = RigEventKind::kStopped, .text = std::string(reason)});
  }
  faultlab::core::Result<SelfTestReport> SelfTest(Epoch) override { return SelfTestReport{}; }
  std::optional<Trip> trip() const override { return std::nullopt; }
  LoopQuality loop_quality() const override { return {}; }

 private:
  RigDescription description_;
  RigState state_ = RigState::kIdle;
  std::vector<RigMessage> told_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace faultlab::fuzz;  // NOLINT(google-build-using-namespace)
  static const std::string kFolder =
      std::filesystem::exists("/dev/shm") ? "/dev/shm/fuzz_agent_" + std::to_string(getpid()) : ".";
  std::filesystem::create_directories(kFolder);
  std::filesystem::remove(kFolder + "/" + kRig + ".epoch");
  Input input(data, size);
  DeafBus bus;
  Bench bench;
  Nanoseconds now{1};
  RigAgent agent(
      bench,
      bus,
      {.key = Key(), .calibration = {}, .ring_items = 64},
      EpochFile::Open(kFolder, kRig).value(),
      [&now] { return now; },
      [] { return std::int64_t{1}; });
  std::int64_t counter = 0;
  for (int i = 0; i < 24 && !input.empty(); ++i) {
    const int flags = input.Byte();
    SealedInput<faultlab_msgs::rig_command_t> said(input.Piece());
    if (said.message && (flags & 1) != 0) {
      said.message->boot = agent.boot();
      said.message->counter = ++counter;
      said.message->holder = "lab/a";
      if ((flags & 2) != 0) said.message->epoch = static_cast<std::int64_t>(agent.epoch());
    }
    agent.OnCommand(said.Bytes(CommandChannel(kRig)));
    now += Nanoseconds((flags >> 2) * 10'000'000);
    agent.Poll();
    Require(agent.counts().forged <= static_cast<std::uint64_t>(i) + 1);
  }
  return 0;
}
