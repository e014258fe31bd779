// The agent alone; the test passes its messages directly: who may command?
#include "hardware/lcm/rig_agent.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "core/signals/random.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/sealed_message.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/remote_world.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/wire_message.h"
#include "tests/paper_bench.h"
#include "tests/support/scale.h"

namespace faultlab::hardware {
namespace {

/// A rig that counts what was read from it.
class CountedRig : public Rig {
 public:
  explicit CountedRig(std::unique_ptr<Rig> rig) : rig_(std::move(rig)) {}

  const RigDescription& description() const override { return rig_->description(); }
  RigState state() const override { return rig_->state(); }
  core::Status Arm(RunPlan plan, Epoch epoch) override { return rig_->Arm(std::move(plan), epoch); }
  core::Status Start(Epoch epoch) override { return rig_->Start(epoch); }
  core::Status Command(Epoch epoch, const RigCommand& command) override {
    return rig_->Command(epoch, command);
  }
  void KeepAlive(Epoch epoch) override { rig_->KeepAlive(epoch); }
  ReadStatus Read(std::vector<RigMessage>& out, std::chrono::milliseconds patience) override {
    const std::size_t before = out.size();
    const ReadStatus status = rig_->Read(out, patience);
    items += static_cast<std::int64_t>(out.size() - before);
    for (std::size_t i = before; i < out.size(); ++i) {
      if (std::holds_alternative<core::Sample>(out[i])) ++samples;
    }
    return status;
  }
  void Fence(Epoch epoch) override { rig_->Fence(epoch); }
  void SafeStop(std::string_view reason) override { rig_->SafeStop(reason); }
  core::Result<SelfTestReport> SelfTest(Epoch epoch) override { return rig_->SelfTest(epoch); }
  std::optional<Trip> trip() const override { return rig_->trip(); }
  LoopQuality loop_quality() const override { return rig_->loop_quality(); }

  std::int64_t items = 0;
  std::int64_t samples = 0;

 private:
  std::unique_ptr<Rig> rig_;
};

class RigAgentAlone : public testing::Test {
 protected:
  RigAgentAlone() {
    SimulatedRigOptions options;
    options.id = "far-1";
    options.speed = 0.0;
    rig_ = MakeSimulatedRig(options);
    end_ = bus_.MakeEnd();
    watcher_ = bus_.MakeEnd();
    watcher_->Subscribe(
        "FAULTLAB\\.far-1\\.REPLY", [this](const std::string&, MessageBus::Bytes bytes) {
          reply_ =
              Opened<faultlab_msgs::rig_reply_t>(bytes, ReplyChannel("far-1"), "far-1", TestKey())
                  .value();
        });
    StartAgent();
  }

  /// Starts the agent's program again; it knows only what is in its file.
  void StartAgent(const std::string& state = "") {
    agent_.reset();
    end_ = bus_.MakeEnd();
    agent_ = std::make_unique<RigAgent>(
        *rig_,
        *end_,
        RigAgentSettings{.key = TestKey(), .calibration = {}},
        EpochFile::Open(state.empty() ? state_.path() : state, "far-1").value(),
        [this] { return now_; },
        [] { return std::int64_t{0}; });
  }

  faultlab_msgs::rig_command_t NewCommand(const std::string& action) {
    faultlab_msgs::rig_command_t command{};
    command.rig = "far-1";
    command.boot = agent_->boot();
    command.holder = "lab/server";
    command.counter = ++counter_;
    command.epoch = static_cast<std::int64_t>(agent_->epoch());
    command.request = counter_;
    command.action = action;
    return command;
  }
  static std::vector<std::uint8_t> InSeal(const faultlab_msgs::rig_command_t& command) {
    return SealBytes(ToBytes(command), CommandChannel("far-1"), "far-1", TestKey());
  }
  void Give(const std::vector<std::uint8_t>& bytes) { agent_->OnCommand(bytes); }
  const faultlab_msgs::rig_reply_t& Answer(const faultlab_msgs::rig_command_t& command) {
    Give(InSeal(command));
    watcher_->Handle(std::chrono::milliseconds(0));
    return reply_;
  }
  const faultlab_msgs::rig_reply_t& Lease(std::int64_t epoch, const std::string& holder) {
    auto command = NewCommand("lease");
    command.epoch = epoch;
    command.holder = holder;
    return Answer(command);
  }
  const faultlab_msgs::rig_reply_t& Say(const std::string& action,
                                        std::int64_t epoch,
                                        const std::string& holder) {
    auto command = NewCommand(action);
    command.epoch = epoch;
    command.holder = holder;
    return Answer(command);
  }
  bool Refused(core::ErrorCode code, const std::string& text) const {
    return reply_.ok == 0 && static_cast<core::ErrorCode>(reply_.code) == code &&
           reply_.message.find(text) != std::string::npos;
  }
  void BeginRun(std::int64_t epoch,
                const std::string& holder,
                const std::vector<faultlab_msgs::fault_t>& faults = {}) {
    auto chunk = NewCommand("plan");
    chunk.epoch = epoch;
    chunk.holder = holder;
    chunk.uc_v.assign(kPlanChunkSamples, 2.0);
    chunk.uc_count = kPlanChunkSamples;
    Give(InSeal(chunk));
    auto arm = NewCommand("arm");
    arm.epoch = epoch;
    arm.holder = holder;
    arm.to = kPlanChunkSamples;
    arm.period_s = 0.01;
    arm.faults = faults;
    arm.fault_count = static_cast<std::int32_t>(faults.size());
    ASSERT_TRUE(Answer(arm).ok) << reply_.message;
    ASSERT_EQ(rig_->state(), RigState::kArmed);
  }
  std::string FileText() const {
    std::ifstream file(state_.path() + "/far-1.epoch");
    return {(std::istreambuf_iterator<char>(file)), {}};
  }

  Nanoseconds now_{0};
  std::int64_t counter_ = 0;
  const StateFolder state_;
  LossyBus bus_{Weather{}, 1};
  std::unique_ptr<MessageBus> end_;
  std::unique_ptr<MessageBus> watcher_;
  faultlab_msgs::rig_reply_t reply_{};
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<RigAgent> agent_;
};

TEST_F(RigAgentAlone, TakesTheEpochOfASignedLeaseAndMakesNoneItself) {
  EXPECT_EQ(agent_->epoch(), Epoch{0});
  EXPECT_TRUE(Lease(41, "lab/a").ok);
  EXPECT_EQ(agent_->epoch(), Epoch{41});
  EXPECT_TRUE(Say("alive", 41, "lab/a").ok);
  EXPECT_TRUE(Say("release", 41, "lab/a").ok);
  EXPECT_EQ(agent_->epoch(), Epoch{41});
  EXPECT_EQ(agent_->counts().accepted, 3u);
}

TEST_F(RigAgentAlone, RefusesALowerEpochAndNamesBoth) {
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  ASSERT_TRUE(Say("release", 41, "lab/a").ok);
  (void)Lease(40, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "seen epoch 41 of lab/a, this lease is of epoch 40"))
      << reply_.message;
  EXPECT_EQ(reply_.field, kLeaseField);
  EXPECT_EQ(reply_.epoch, 41);
  EXPECT_EQ(agent_->counts().stale, 1u);
  (void)Say("nominal", 40, "lab/a");
  EXPECT_EQ(reply_.ok, 0);
}

TEST_F(RigAgentAlone, GivesItsEpochAgainToTheLabThatHadItAndToNoOther) {
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  ASSERT_TRUE(Say("release", 41, "lab/a").ok);
  (void)Lease(41, "other/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "seen epoch 41 of lab/a")) << reply_.message;
  EXPECT_TRUE(Lease(41, "lab/b").ok) << "a lab makes each epoch once";
  (void)Lease(41, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kUnavailable, "still waits for lab/b")) << reply_.message;
}

TEST_F(RigAgentAlone, AHigherEpochOfItsLabTakesTheRigAtOnceAndEndsTheOlderRun) {
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  BeginRun(41, "lab/a");
  EXPECT_TRUE(Lease(42, "lab/b").ok) << reply_.message;
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  (void)Say("start", 41, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "held by lab/b")) << reply_.message;
  (void)Say("start", 42, "lab/a");
  EXPECT_EQ(reply_.ok, 0) << "and a right epoch in wrong hands is of no use";
}

TEST_F(RigAgentAlone, AnotherLabWaitsUntilTheHolderIsSilentWhateverItsEpoch) {
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  BeginRun(41, "lab/a");
  (void)Lease(1000, "other/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kBusy, "held by lab/a")) << reply_.message;
  EXPECT_EQ(reply_.field, kLeaseField);
  EXPECT_EQ(rig_->state(), RigState::kArmed);
  EXPECT_EQ(agent_->epoch(), Epoch{41});
  now_ += std::chrono::seconds(6);
  agent_->Poll();
  EXPECT_TRUE(Lease(1000, "other/a").ok) << reply_.message;
}

TEST_F(RigAgentAlone, AskedTwiceForTheSameLeaseItGoesOnWithWhatRuns) {
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  BeginRun(41, "lab/a");
  EXPECT_TRUE(Lease(41, "lab/a").ok);
  EXPECT_EQ(rig_->state(), RigState::kArmed);
}

TEST_F(RigAgentAlone, RefusesALeaseWithoutAnEpochAsAnOlderServerAsksForIt) {
  (void)Lease(-1, "server-77");
  EXPECT_TRUE(Refused(core::ErrorCode::kInvalid, "older version")) << reply_.message;
  EXPECT_EQ(agent_->epoch(), Epoch{0});
}

TEST_F(RigAgentAlone, KnowsItsEpochAndWhoseItWasAfterARestart) {
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  EXPECT_EQ(FileText(), "41 lab/a\n");
  StartAgent();
  EXPECT_EQ(agent_->epoch(), Epoch{41});
  (void)Lease(40, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "seen epoch 41")) << reply_.message;
  (void)Lease(41, "other/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "seen epoch 41 of lab/a")) << reply_.message;
  (void)Say("nominal", 41, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "no lease")) << reply_.message;
  EXPECT_TRUE(Lease(41, "lab/a").ok) << "the session goes on";
}

TEST_F(RigAgentAlone, ThatCannotKeepItsEpochGivesNoLeaseAndSaysWhyButEndsTheOlderRun) {
  const std::string folder = state_.path() + "/deeper";
  StartAgent(folder);
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  BeginRun(41, "lab/a");
  std::filesystem::remove_all(folder);
  std::ofstream(folder) << "a file where the folder was\n";
  (void)Lease(42, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kUnavailable, folder + "/far-1.epoch")) << reply_.message;
  EXPECT_EQ(reply_.field, kLeaseField);
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  (void)Say("nominal", 42, "lab/a");
  EXPECT_EQ(reply_.ok, 0);
  (void)Lease(41, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "seen epoch 42")) << reply_.message;
  std::filesystem::remove(folder);
  EXPECT_TRUE(Lease(42, "lab/a").ok) << reply_.message;
}

TEST(EpochFileTest, ThatHoldsSomethingElseIsRefused) {
  const StateFolder state;
  const std::string path = state.path() + "/far-1.epoch";
  for (const char* text :
       {"", "\n", "41", "41\n", "41 \n", "0 lab/a\n", "forty lab/a\n", "41 lab"}) {
    std::ofstream(path) << text;
    const auto opened = EpochFile::Open(state.path(), "far-1");
    ASSERT_FALSE(opened.ok()) << text;
    EXPECT_NE(opened.error().message.find(path), std::string::npos);
  }
  std::ofstream(path) << "41 a lab/of two words\n";
  EXPECT_EQ(EpochFile::Open(state.path(), "far-1").value().seen(),
            (SeenLease{41, "a lab/of two words"}));
}

TEST_F(RigAgentAlone, RefusesTheSameMessageTwice) {
  auto command = NewCommand("lease");
  command.epoch = 1;
  const auto lease = InSeal(command);
  Give(lease);
  Give(lease);
  EXPECT_EQ(agent_->counts().replayed, 1u);
  EXPECT_EQ(agent_->counts().accepted, 1u);
}

TEST_F(RigAgentAlone, RefusesAMessageForAnEarlierStart) {
  auto command = NewCommand("lease");
  command.boot += 1;
  Give(InSeal(command));
  EXPECT_EQ(agent_->counts().replayed, 1u);
  EXPECT_EQ(agent_->counts().accepted, 0u);
}

TEST_F(RigAgentAlone, ALeaseEndsByItselfAndIsGivenAgainWithItsEpoch) {
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  BeginRun(41, "lab/a");
  now_ += std::chrono::seconds(6);
  agent_->Poll();
  EXPECT_EQ(agent_->epoch(), Epoch{41});
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  (void)Say("nominal", 41, "lab/a");
  EXPECT_TRUE(Refused(core::ErrorCode::kStale, "no lease")) << reply_.message;
  EXPECT_TRUE(Lease(41, "lab/a").ok);
  EXPECT_TRUE(Say("nominal", 41, "lab/a").ok);
}

TEST_F(RigAgentAlone, ShowsTheBusOneMessageOfOneLengthASampleHoweverManyFaultsBegin) {
  constexpr std::int64_t kCatchesUpBeyond = 64;  // items that wait: the agent was held up
  SimulatedRigOptions options;
  options.id = "far-1";
  options.watchdog = std::chrono::seconds(30);  // a busy machine is not a silent holder
  agent_.reset();
  auto counted = std::make_unique<CountedRig>(MakeSimulatedRig(options));
  const CountedRig& reads = *counted;
  rig_ = std::move(counted);
  StartAgent();
  std::set<std::size_t> sizes;
  std::int64_t messages = 0;
  std::int64_t next_seq = 0;
  int commanded = 0;
  watcher_->Subscribe(
      "FAULTLAB\\.far-1\\.STREAM", [&](const std::string&, MessageBus::Bytes bytes) {
        const auto piece =
            Opened<faultlab_msgs::rig_stream_t>(bytes, StreamChannel("far-1"), "far-1", TestKey())
                .value();
        sizes.insert(bytes.size());
        ++messages;
        EXPECT_EQ(piece.first_seq, next_seq);
        next_seq += piece.count;
        for (const auto& item : piece.items) {
          if (item.kind == Name(RigEventKind::kFaultCommanded)) ++commanded;
        }
      });
  ASSERT_TRUE(Lease(41, "lab/a").ok);
  std::vector<faultlab_msgs::fault_t> faults;
  for (const core::Component component : paper::Parts()) {
    const double value = 1.2 * paper::Plant().Get(component);
    faults.push_back(ToMessage({.component = component, .value = value, .at_s = 0.3}));
  }
  BeginRun(41, "lab/a", faults);
  ASSERT_TRUE(Say("start", 41, "lab/a").ok) << reply_.message;
  int judged = 0;
  do {
    const std::int64_t samples_before = reads.samples;
    const std::int64_t messages_before = messages;
    const std::int64_t published_before = next_seq;
    agent_->Poll();
    watcher_->Handle(std::chrono::milliseconds(1));
    // Rests of a run that has ended are sent at once; so is what an agent missed while held up.
    if (rig_->state() != RigState::kRunning) continue;
    if (reads.items - published_before > kCatchesUpBeyond) continue;
    ++judged;
    EXPECT_LE(messages - messages_before, reads.samples - samples_before)
        << "messages without a sample";
  } while (rig_->state() == RigState::kRunning);
  agent_->Poll();
  watcher_->Handle(std::chrono::milliseconds(0));
  EXPECT_GT(judged, 0);
  EXPECT_EQ(sizes.size(), 1u);
  EXPECT_EQ(commanded, static_cast<int>(faults.size()));
  EXPECT_GE(next_seq, kPlanChunkSamples + commanded);
}

TEST_F(RigAgentAlone, AnAnswerThatWasLostIsGivenAgainWithoutActingTwice) {
  ASSERT_TRUE(Lease(1, "lab/server").ok);
  auto again = NewCommand("lease");
  again.epoch = 2;
  again.request = 1;  // of the first
  EXPECT_TRUE(Answer(again).ok);
  EXPECT_EQ(agent_->epoch(), Epoch{1});
}

TEST_F(RigAgentAlone, AcceptsNothingOfForgedReplayedAndStaleTries) {
  ASSERT_TRUE(Lease(7, "lab/server").ok);
  auto recorded = InSeal(NewCommand("nominal"));
  Give(recorded);
  const auto stale = [&](int i) {
    auto command = NewCommand(i % 2 == 0 ? "set" : "lease");
    command.epoch -= 1 + i % 5;
    if (i % 2 != 0) command.epoch = std::max<std::int64_t>(command.epoch, 1);
    command.component = "R1";
    command.value = 100.0;
    return InSeal(command);
  };
  const std::uint64_t accepted = agent_->counts().accepted;
  core::Random random(7);
  const int kTries = tests::Proving() ? 1'000'000 : 60'000;
  const int kStale = kTries / 20;  // each needs its own seal
  for (int i = 0; i < kTries - kStale; ++i) {
    auto bytes = recorded;
    if (i % 4 != 0) {
      // Flips one to three bits anywhere: head, nonce, box, tag.
      for (std::uint64_t n = 1 + random.Below(3); n > 0; --n) {
        bytes[random.Below(bytes.size())] ^= static_cast<std::uint8_t>(1u << random.Below(8));
      }
    }
    if (i % 4 == 3) bytes.resize(random.Below(bytes.size()));
    Give(bytes);
  }
  for (int i = 0; i < kStale; ++i) Give(stale(i));
  const RigAgentCounts& counts = agent_->counts();
  EXPECT_EQ(counts.accepted, accepted);
  EXPECT_EQ(counts.stale, static_cast<std::uint64_t>(kStale));
  EXPECT_EQ(counts.forged + counts.replayed, static_cast<std::uint64_t>(kTries - kStale));
  EXPECT_EQ(rig_->state(), RigState::kIdle);
}

TEST_F(RigAgentAlone, RefusesBadLengthsEvenUnderTheRightKey) {
  core::Random random(5);
  std::uint64_t given = 0;
  for (int i = 0; i < 10; ++i) {
    const WireMessage wire = MakeWireMessage<faultlab_msgs::rig_command_t>(random);
    std::vector<std::size_t> places = wire.strings;
    places.insert(places.end(), wire.counts.begin(), wire.counts.end());
    for (const std::size_t at : places) {
      for (const std::int32_t length : kBadLengths) {
        std::vector<std::uint8_t> bytes = wire.bytes;
        PutInt(bytes, at, length);
        Give(SealBytes(bytes, CommandChannel("far-1"), "far-1", TestKey()));
        ++given;
      }
    }
  }
  EXPECT_GT(given, 300u);
  EXPECT_EQ(agent_->counts().forged, given);
}

TEST_F(RigAgentAlone, RefusesAPlanThatIsNoPlan) {
  ASSERT_TRUE(Lease(1, "lab/server").ok);
  auto chunk = NewCommand("plan");
  chunk.from = 7;  // not at a border
  chunk.uc_v.assign(10, 1.0);
  chunk.uc_count = 10;
  Give(InSeal(chunk));
  auto arm = NewCommand("arm");
  arm.to = 1'000'000'000;
  arm.period_s = 0.01;
  Give(InSeal(arm));
  EXPECT_EQ(rig_->state(), RigState::kIdle);
}

}  // namespace
}  // namespace faultlab::hardware
