// A driver call that does not return must not block other threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "hardware/daq/guarded_daq.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/test_bench.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

constexpr RigCommand kClear{.kind = RigCommand::Kind::kClearTrip};
constexpr Nanoseconds kPatience = std::chrono::milliseconds(20);

TestBenchOptions Guarded() {
  return {.clock = nullptr,
          .watchdog = {},
          .limits = paper::Bench().limits,
          .driver_patience = kPatience};
}

RunPlan ShortPlan() {
  RunPlan plan = SquarePlan(8);
  plan.faults = {{.component = paper::kR1, .value = 10.0, .at_s = 0.03}};
  return plan;
}

TEST(DriverHang, AtEveryCallComesBackAsALatchedTripAndClearsWhenTheDriverAnswers) {
  int calls = 0;
  {
    TestBenchOptions patient = Guarded();  // a busy machine may delay this one
    patient.driver_patience = std::chrono::seconds(5);
    TestBench whole(patient);
    ASSERT_TRUE(whole.rig->Arm(ShortPlan(), kEpoch).ok());
    ASSERT_TRUE(whole.rig->Start(kEpoch).ok());
    (void)Drain(*whole.rig);
    calls = whole.journal.calls;
  }
  ASSERT_GT(calls, 30);
  int stopped_runs = 0;
  TestBenchOptions options = Guarded();
  for (int n = 0; n < calls;) {
    TestBench bench(options);
    bench.journal.hang_at = n;
    RunLog log;
    const bool armed = bench.rig->Arm(ShortPlan(), kEpoch).ok();
    if (armed) {
      const bool started = bench.rig->Start(kEpoch).ok();
      if (started) log = Drain(*bench.rig);
      ASSERT_TRUE(started || !bench.journal.hangs()) << n;
    }
    bench.rig->SafeStop("asked while the driver hangs");
    if (!bench.journal.hangs()) {  // a busy machine may have delayed an earlier call
      options.driver_patience *= 2;
      ASSERT_LT(options.driver_patience, std::chrono::minutes(1)) << n;
      continue;
    }
    if (armed) {
      EXPECT_EQ(log.events.back().kind, RigEventKind::kStopped) << n;
      EXPECT_EQ(log.Of(RigEventKind::kTrip).size(), 1u) << n;
      ++stopped_runs;
    }
    ASSERT_EQ(bench.rig->state(), RigState::kTripped) << n;
    EXPECT_EQ(bench.rig->trip()->name, "driver_hang") << n;
    EXPECT_GE(bench.rig->trip()->value, bench.rig->trip()->limit) << n;
    EXPECT_EQ(bench.rig->Arm(ShortPlan(), kEpoch).error().code, core::ErrorCode::kConflict) << n;
    EXPECT_FALSE(bench.rig->Command(kEpoch, kClear).ok()) << "still hung: " << n;

    bench.journal.Release();
    while (!bench.rig->Command(kEpoch, kClear).ok()) std::this_thread::yield();
    EXPECT_EQ(bench.rig->state(), RigState::kIdle) << n;
    EXPECT_TRUE(bench.IsSafe()) << n;
    ++n;
  }
  EXPECT_GT(stopped_runs, 20);
}

TEST(DriverHang, OfAWriteThatReturnsLateIsFollowedByDriveZero) {
  DaqJournal journal;
  journal.hang_at = 0;
  const auto clock = std::make_shared<ManualClock>();
  const BenchConfig config = SimulatedBenchConfig({});
  const auto daq = MakeGuardedDaq(
      std::make_unique<FaultyDaq>(
          std::make_unique<SimulatedDaq>(
              paper::Bench(), paper::Hardware(), config.scaling, config.wiring, clock),
          journal),
      {.patience = kPatience});
  EXPECT_THROW(daq->WriteDrive(3.0), DriverHang);
  EXPECT_THROW(daq->ReadRelayLines(), DriverHang) << "at once, and the driver is left alone";
  journal.Release();
  for (bool answers = false; !answers;) {
    try {
      (void)daq->ReadRelayLines();
      answers = true;
    } catch (const DriverHang&) {
      std::this_thread::yield();
    }
  }
  EXPECT_EQ(journal.drive_v, 0.0) << "3 V went out late";
}

TEST(DriverHang, DoesNotHoldTheEndOfTheDaq) {
  const auto journal = std::make_shared<DaqJournal>();
  journal->hang_at = 0;
  {
    const auto clock = std::make_shared<ManualClock>();
    const BenchConfig config = SimulatedBenchConfig({});
    // Keeps the journal until the driver's thread, which outlives this scope, has ended its use.
    class KeptDaq final : public Daq {
     public:
      KeptDaq(std::shared_ptr<DaqJournal> the_journal, std::unique_ptr<Daq> inner)
          : journal_(std::move(the_journal)), faulty_(std::move(inner), *journal_) {}
      double WriteDrive(double volt) override { return faulty_.WriteDrive(volt); }
      AnalogReading ReadAnalog() override { return faulty_.ReadAnalog(); }
      void WriteRelayLines(std::uint32_t levels) override { faulty_.WriteRelayLines(levels); }
      std::uint32_t ReadRelayLines() override { return faulty_.ReadRelayLines(); }
      double ReadPulseFrequencyHz() override { return faulty_.ReadPulseFrequencyHz(); }
      std::uint32_t ReadPulseCount() override { return faulty_.ReadPulseCount(); }
      void Prepare() override { faulty_.Prepare(); }
      void FeedWatchdog() override { faulty_.FeedWatchdog(); }
      bool has_watchdog() const override { return false; }

     private:
      const std::shared_ptr<DaqJournal> journal_;
      FaultyDaq faulty_;
    };
    const auto daq = MakeGuardedDaq(
        std::make_unique<KeptDaq>(
            journal,
            std::make_unique<SimulatedDaq>(
                paper::Bench(), paper::Hardware(), config.scaling, config.wiring, clock)),
        {.patience = kPatience});
    EXPECT_THROW(daq->WriteDrive(3.0), DriverHang);
  }
  journal->Release();
  while (journal.use_count() > 1) std::this_thread::yield();
  EXPECT_EQ(journal->drive_v, 0.0);
}

}  // namespace
}  // namespace faultlab::hardware
