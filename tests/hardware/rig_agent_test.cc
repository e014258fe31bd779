// The agent alone, with its messages put in by hand: who may command?
#include "hardware/lcm/rig_agent.h"

#include <gtest/gtest.h>

#include "core/signals/random.h"
#include "hardware/lcm/channels.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/remote_world.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/wire_message.h"

namespace faultlab::hardware {
namespace {

class RigAgentAlone : public testing::Test {
 protected:
  RigAgentAlone() {
    SimulatedRigOptions options;
    options.id = "far-1";
    options.speed = 0.0;
    rig_ = MakeSimulatedRig(options);
    end_ = bus_.MakeEnd();
    agent_ = std::make_unique<RigAgent>(
        *rig_,
        *end_,
        RigAgentSettings{.key = TestKey(), .calibration = {}},
        [this] { return now_; },
        [] { return std::int64_t{0}; });
  }

  faultlab_msgs::rig_command_t NewCommand(const std::string& action) {
    faultlab_msgs::rig_command_t command{};
    command.rig = "far-1";
    command.boot = agent_->boot();
    command.holder = "server";
    command.counter = ++counter_;
    command.epoch = static_cast<std::int64_t>(agent_->epoch());
    command.request = counter_;
    command.action = action;
    return command;
  }
  std::vector<std::uint8_t> Signed(faultlab_msgs::rig_command_t command) {
    return SignedBytes(command, TestKey());
  }
  void Give(const std::vector<std::uint8_t>& bytes) { agent_->OnCommand(bytes); }

  Nanoseconds now_{0};
  std::int64_t counter_ = 0;
  LossyBus bus_{Weather{}, 1};
  std::unique_ptr<MessageBus> end_;
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<RigAgent> agent_;
};

TEST_F(RigAgentAlone, TakesASignedLeaseAndRaisesTheEpoch) {
  Give(Signed(NewCommand("lease")));
  EXPECT_EQ(agent_->epoch(), Epoch{1});
  Give(Signed(NewCommand("alive")));
  EXPECT_EQ(agent_->counts().accepted, 2u);
}

TEST_F(RigAgentAlone, RefusesTheSameMessageTwice) {
  const auto lease = Signed(NewCommand("lease"));
  Give(lease);
  Give(lease);
  EXPECT_EQ(agent_->counts().replayed, 1u);
  EXPECT_EQ(agent_->epoch(), Epoch{1});
}

TEST_F(RigAgentAlone, RefusesAMessageForAnEarlierStart) {
  auto command = NewCommand("lease");
  command.boot += 1;
  Give(Signed(command));
  EXPECT_EQ(agent_->counts().replayed, 1u);
  EXPECT_EQ(agent_->counts().accepted, 0u);
}

TEST_F(RigAgentAlone, ALeaseEndsByItselfAndRaisesTheFence) {
  Give(Signed(NewCommand("lease")));
  const auto old = NewCommand("alive");
  now_ += std::chrono::seconds(6);
  agent_->Poll();
  EXPECT_EQ(agent_->epoch(), Epoch{2});
  Give(Signed(old));
  EXPECT_EQ(agent_->counts().not_holder, 1u);
}

TEST_F(RigAgentAlone, AnAnswerThatWasLostIsGivenAgainWithoutActingTwice) {
  Give(Signed(NewCommand("lease")));
  auto again = NewCommand("lease");
  again.request = 1;  // of the first
  Give(Signed(again));
  EXPECT_EQ(agent_->epoch(), Epoch{1});
}

TEST_F(RigAgentAlone, AcceptsNothingOfAMillionForgedReplayedAndStaleTries) {
  Give(Signed(NewCommand("lease")));
  auto recorded = Signed(NewCommand("nominal"));
  Give(recorded);
  const auto stale = [&] {
    auto command = NewCommand("set");
    command.epoch -= 1;
    command.component = "R1";
    command.value = 100.0;
    return Signed(command);
  };
  const std::uint64_t accepted = agent_->counts().accepted;
  core::Random random(7);
  constexpr int kTries = 1'000'000;
  constexpr int kStale = 50'000;  // each needs its own signature
  for (int i = 0; i < kTries - kStale; ++i) {
    auto bytes = recorded;
    if (i % 4 != 0) {
      // One to three bits turned, anywhere: header, counter, action, mac.
      for (std::uint64_t n = 1 + random.Below(3); n > 0; --n) {
        bytes[random.Below(bytes.size())] ^= static_cast<std::uint8_t>(1u << random.Below(8));
      }
    }
    if (i % 4 == 3) bytes.resize(random.Below(bytes.size()));
    Give(bytes);
  }
  for (int i = 0; i < kStale; ++i) Give(stale());
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
        SignAgain(bytes, TestKey());
        Give(bytes);
        ++given;
      }
    }
  }
  EXPECT_GT(given, 300u);
  EXPECT_EQ(agent_->counts().forged, given);
}

TEST_F(RigAgentAlone, RefusesAPlanThatIsNoPlan) {
  Give(Signed(NewCommand("lease")));
  auto chunk = NewCommand("plan");
  chunk.from = 7;  // not at a border
  chunk.uc_v.assign(10, 1.0);
  chunk.uc_count = 10;
  Give(Signed(chunk));
  auto arm = NewCommand("arm");
  arm.to = 1'000'000'000;
  arm.period_s = 0.01;
  Give(Signed(arm));
  EXPECT_EQ(rig_->state(), RigState::kIdle);
}

}  // namespace
}  // namespace faultlab::hardware
