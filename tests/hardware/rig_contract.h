#pragma once

// The tests that every Rig passes: include this and instantiate RigContract for the kinds of rigs
// of the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hardware/rig.h"
#include "tests/hardware/rig_runs.h"

namespace faultlab::hardware {

inline constexpr Epoch kContractEpoch{7};
inline constexpr Epoch kOlder{6};
inline constexpr Epoch kNewer{8};

inline constexpr int kSamples = 300;

struct RigUnderContract {
  const char* name;
  std::unique_ptr<Rig> (*make)();
  RunPlan (*plan)();  ///< of kSamples samples at 100 Hz
  /// How far um of a repeated run may differ: a motor is not the same twice.
  double repeats_within_v = 0.0;
  bool is_far = false;  ///< a fence reaches it when the network does
};

class RigContract : public testing::TestWithParam<RigUnderContract> {
 protected:
  std::unique_ptr<Rig> rig_ = GetParam().make();
  RunPlan plan_ = GetParam().plan();
};

TEST_P(RigContract, PlaysItsPlanToTheEndAndIsIdleAgain) {
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  EXPECT_EQ(rig_->state(), RigState::kArmed);
  ASSERT_TRUE(rig_->Start(kContractEpoch));
  const RunLog log = Drain(*rig_);
  ASSERT_EQ(log.samples.size(), static_cast<std::size_t>(kSamples));
  for (int k = 0; k < kSamples; ++k) {
    EXPECT_EQ(log.samples[static_cast<std::size_t>(k)].index, k);
    EXPECT_DOUBLE_EQ(log.samples[static_cast<std::size_t>(k)].t_s, k * 0.01);
  }
  ASSERT_FALSE(log.events.empty());
  EXPECT_EQ(log.events.front().kind, RigEventKind::kStarted);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  EXPECT_EQ(log.events.back().index, kSamples);
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  EXPECT_EQ(rig_->loop_quality().lateness.count() > 0, true);
}

TEST_P(RigContract, RunsAgainWithTheSameSamples) {
  RunLog first;
  RunLog second;
  for (RunLog* log : {&first, &second}) {
    ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
    ASSERT_TRUE(rig_->Start(kContractEpoch));
    *log = Drain(*rig_);
  }
  ASSERT_EQ(first.samples.size(), second.samples.size());
  for (std::size_t k = 0; k < first.samples.size(); ++k) {
    EXPECT_NEAR(first.samples[k].um_v, second.samples[k].um_v, GetParam().repeats_within_v) << k;
  }
}

TEST_P(RigContract, RefusesAnOlderEpochEverywhere) {
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  EXPECT_EQ(rig_->Arm(plan_, kOlder).error().code, core::ErrorCode::kStale);
  EXPECT_EQ(rig_->Start(kOlder).error().code, core::ErrorCode::kStale);
  EXPECT_EQ(rig_->Command(kOlder, {}).error().code, core::ErrorCode::kStale);
  EXPECT_EQ(rig_->state(), RigState::kArmed);
}

TEST_P(RigContract, AFenceStopsTheRunOfTheOldHolder) {
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  ASSERT_TRUE(rig_->Start(kContractEpoch));
  rig_->Fence(kNewer);
  if (!GetParam().is_far) {
    EXPECT_EQ(rig_->state(), RigState::kIdle);
  }
  EXPECT_EQ(rig_->Start(kContractEpoch).error().code, core::ErrorCode::kStale);
  const RunLog log = Drain(*rig_);
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  EXPECT_THAT(log.last_text(), testing::AnyOf("the lease was revoked", ""));
  ASSERT_TRUE(rig_->Arm(plan_, kNewer));
}

TEST_P(RigContract, AFenceThatIsNotNewerChangesNothing) {
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  rig_->Fence(kContractEpoch);
  rig_->Fence(kOlder);
  EXPECT_EQ(rig_->state(), RigState::kArmed);
  EXPECT_TRUE(rig_->Start(kContractEpoch));
  EXPECT_EQ(Drain(*rig_).samples.size(), static_cast<std::size_t>(kSamples));
}

TEST_P(RigContract, StartsOnlyWhenArmed) {
  EXPECT_EQ(rig_->Start(kContractEpoch).error().code, core::ErrorCode::kConflict);
}

TEST_P(RigContract, SafeStopEndsTheStreamWithTheReasonOrTheEndOfThePlan) {
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  ASSERT_TRUE(rig_->Start(kContractEpoch));
  rig_->SafeStop("the test says so");
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  const RunLog log = Drain(*rig_);
  ASSERT_FALSE(log.events.empty());
  if (log.samples.size() < kSamples) {
    EXPECT_EQ(log.events.back().kind, RigEventKind::kStopped);
    EXPECT_EQ(log.last_text(), "the test says so");
  }
}

TEST_P(RigContract, SafeStopIsHarmlessInEveryStateAndFromManyThreads) {
  rig_->SafeStop("idle");
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  rig_->SafeStop("armed");
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  EXPECT_EQ(Drain(*rig_).samples.size(), 0u);
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  ASSERT_TRUE(rig_->Start(kContractEpoch));
  std::vector<std::thread> stoppers;
  for (int i = 0; i < 4; ++i) {
    stoppers.emplace_back([this] { rig_->SafeStop("one of many"); });
  }
  for (std::thread& stopper : stoppers) stopper.join();
  EXPECT_EQ(rig_->state(), RigState::kIdle);
}

TEST_P(RigContract, ClosingARunningRigStopsIt) {
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  ASSERT_TRUE(rig_->Start(kContractEpoch));
  rig_.reset();
  EXPECT_EQ(rig_, nullptr);
}

TEST_P(RigContract, ReadsAsEndedWhenNothingIsArmed) {
  std::vector<RigMessage> messages;
  EXPECT_EQ(rig_->Read(messages, std::chrono::milliseconds(0)), ReadStatus::kEnded);
  EXPECT_TRUE(messages.empty());
}

TEST_P(RigContract, SelfTestPassesWhenIdle) {
  const core::Result<SelfTestReport> report = rig_->SelfTest(kContractEpoch);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_TRUE(report.value().ok);
  EXPECT_EQ(rig_->state(), RigState::kIdle);
  ASSERT_TRUE(rig_->Arm(plan_, kContractEpoch));
  EXPECT_EQ(rig_->SelfTest(kContractEpoch).error().code, core::ErrorCode::kConflict);
}

TEST_P(RigContract, RefusesASelfTestOfAnOlderEpoch) {
  rig_->Fence(kContractEpoch);
  EXPECT_EQ(rig_->SelfTest(kOlder).error().code, core::ErrorCode::kStale);
  ASSERT_TRUE(rig_->SelfTest(kNewer).ok());
  EXPECT_EQ(rig_->Arm(plan_, kContractEpoch).error().code, core::ErrorCode::kStale);
}

TEST_P(RigContract, NamesThePartOfAPlanThatItRefuses) {
  RunPlan plan = plan_;
  plan.period_s = 0.0;
  const core::Status refused = rig_->Arm(plan, kContractEpoch);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "period_s");
  EXPECT_EQ(rig_->state(), RigState::kIdle);
}

inline std::string NameOfKind(const testing::TestParamInfo<RigUnderContract>& kind) {
  return kind.param.name;
}

}  // namespace faultlab::hardware
