#include "core/diagnosis/pipeline.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>
#include <variant>

#include "core/diagnosis/diagnose_record.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

TEST(Pipeline, SaysTheSameAsARecordWhenItsTasksComeBackAtOnce) {
  const auto record = BenchRecord({AbruptFault(paper::kR1, 100.0)}, 31);
  DiagnosisOptions config = paper::Options();
  config.channels = Channels::kUmOnly;
  Pipeline pipeline(config);
  std::uint64_t version = pipeline.verdict_version();
  bool named_within_a_second = false;
  for (const Sample& sample : record) {
    pipeline.Push(sample);
    while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
    EXPECT_GE(pipeline.verdict_version(), version);
    version = pipeline.verdict_version();
    if (sample.t_s < 11.05 && Names(pipeline.verdict(), paper::kR1)) {
      named_within_a_second = true;
    }
  }
  EXPECT_TRUE(named_within_a_second);
  const Diagnosis live = pipeline.Finish();
  const Diagnosis offline = DiagnoseRecord(record, FreeValues(Channels::kUmOnly));
  ASSERT_FALSE(live.verdict.candidates.empty());
  EXPECT_EQ(live.verdict.candidates.front().value, offline.verdict.candidates.front().value);
}

/// How long after the fault the verdict names a component for the first time, whichever.
struct FirstName {
  double after_s = 1e9;
  bool right = false;
};

FirstName FirstNameOf(const Fault& fault, std::uint64_t seed) {
  FirstName first;
  DiagnoseRecord(BenchRecord({fault}, seed, 14.0),
                 FreeValues(Channels::kAll),
                 [&](const Verdict& verdict, std::int64_t index) {
                   if (first.after_s < 1e9 || verdict.group.empty()) return;
                   const double now_s = static_cast<double>(index) * paper::kPeriodS;
                   first = {now_s - fault.at_s, Names(verdict, fault.component)};
                   EXPECT_GT(ProbabilityOf(verdict), 0.99) << verdict.reason;
                 });
  return first;
}

TEST(Pipeline, NamesALargeFaultWithinFiveSamplesOfItsAlarm) {
  std::uint64_t seed = 300;
  for (const auto& [component, value] : {std::pair{paper::kR1, 100.0},
                                         {paper::kR9, 33e3},
                                         {paper::kR12, 3.3e3},
                                         {paper::kC8, 47e-6},
                                         {paper::kRa, 74.0}}) {
    const FirstName first = FirstNameOf(AbruptFault(component, value), ++seed);
    EXPECT_TRUE(first.right) << Name(component);
    EXPECT_LE(first.after_s, 0.07) << Name(component) << ": two of them until the alarm";
  }
}

TEST(Pipeline, SaysNothingEarlyOfAFaultThatCreeps) {
  for (const auto& [component, value] : {std::pair{paper::kRa, 15.0}, {paper::kR1, 60.0}}) {
    Fault creeps = AbruptFault(component, value);
    creeps.kind = FaultKind::kDrift;
    creeps.until_s = 13.0;
    const FirstName first = FirstNameOf(creeps, 320);
    EXPECT_TRUE(first.right) << Name(component);
    EXPECT_GT(first.after_s, 0.2) << Name(component);
  }
}

TEST(Pipeline, ThatLearnsAgainSaysTheSameAsARecordWithThatStretch) {
  constexpr double kFromS = 7.0;
  // The first stretch is spoilt, the rig is healthy again at 6.5 s.
  core::Fault spoilt = AbruptFault(paper::kR1, 10.0, 3.0);
  core::Fault mended = AbruptFault(paper::kR1, paper::Plant().Get(paper::kR1), 6.5);
  const auto record = BenchRecord({spoilt, mended, AbruptFault(paper::kR1, 100.0, 14.0)}, 33, 20.0);
  const auto work = [](Pipeline& pipeline) {
    while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
  };
  Pipeline pipeline{paper::Options()};
  for (const Sample& sample : record) {
    if (sample.t_s < kFromS) {
      pipeline.Push(sample);
      work(pipeline);
      continue;
    }
    if (sample.index == 700) {
      EXPECT_EQ(pipeline.learning(), Learning::kGivenUp);
      const std::uint64_t version = pipeline.verdict_version();
      pipeline.LearnAgain(sample.t_s);
      EXPECT_GT(pipeline.verdict_version(), version);
      EXPECT_EQ(pipeline.learning(), Learning::kStretch);
      EXPECT_EQ(pipeline.calibration(), nullptr);
    }
    pipeline.Push(sample);
    work(pipeline);
  }
  const Diagnosis live = pipeline.Finish();
  EXPECT_TRUE(Names(live.verdict, paper::kR1));
  EXPECT_FALSE(live.calibration_refusal);
  DiagnosisOptions options = paper::Options();
  options.healthy_from_s = kFromS;
  options.healthy_to_s = kFromS + 4.5;
  const Diagnosis offline = DiagnoseRecord(record, options);
  ASSERT_FALSE(live.verdict.candidates.empty());
  ASSERT_FALSE(offline.verdict.candidates.empty());
  EXPECT_EQ(live.verdict.candidates.front().value, offline.verdict.candidates.front().value);
  EXPECT_EQ(live.estimates[0].theta[0], offline.estimates[0].theta[0]);
}

TEST(Pipeline, SaysHowFarItIsWithLearningTheHealthyRig) {
  DiagnosisOptions config = paper::Options();
  Pipeline pipeline(config);
  std::optional<DiagnosisTask> task;
  for (const Sample& sample : BenchRecord({}, 36, 8.0)) {
    EXPECT_EQ(pipeline.learning(), sample.t_s < 5.005 ? Learning::kStretch : Learning::kSolving)
        << sample.t_s;
    pipeline.Push(sample);
    if (!task) task = pipeline.TakeTask();
  }
  ASSERT_TRUE(task);
  pipeline.Accept(RunTask(*task));
  EXPECT_EQ(pipeline.learning(), Learning::kLearnt);

  config.calibration = *pipeline.calibration();
  EXPECT_EQ(Pipeline(config).learning(), Learning::kLearnt);

  Pipeline spoilt{paper::Options()};
  for (const Sample& sample : BenchRecord({AbruptFault(paper::kR1, 10.0, 3.0)}, 20, 8.0)) {
    spoilt.Push(sample);
    while (auto work = spoilt.TakeTask()) spoilt.Accept(RunTask(*work));
  }
  EXPECT_EQ(spoilt.learning(), Learning::kGivenUp);
}

TEST(Pipeline, DetectsEvenWhenNobodySolvesItsTasksInTime) {
  const auto record = BenchRecord({AbruptFault(paper::kR12, 5.6e3)}, 32);
  DiagnosisOptions config = paper::Options();
  Pipeline pipeline(config);
  std::optional<DiagnosisTask> late;
  for (const Sample& sample : record) {
    pipeline.Push(sample);
    auto task = pipeline.TakeTask();
    if (!task) continue;
    if (std::holds_alternative<CalibrationTask>(*task)) {
      late = std::move(task);  // accepted three seconds late
    }
    if (late && sample.t_s > 8.0) {
      pipeline.Accept(RunTask(*late));
      late.reset();
    }
  }
  if (late) pipeline.Accept(RunTask(*late));
  EXPECT_TRUE(pipeline.verdict().detected_at_s.has_value());
  EXPECT_NEAR(*pipeline.verdict().detected_at_s, 10.0, 0.031);
}

TEST(Pipeline, RemembersTheOnsetOfAFaultThatIsLongSince) {
  const Diagnosis diagnosis = DiagnoseRecord(
      BenchRecord({AbruptFault(paper::kR1, 100.0)}, 35, 90.0), FreeValues(Channels::kAll));
  ASSERT_TRUE(Names(diagnosis.verdict, paper::kR1)) << diagnosis.verdict.reason;
  EXPECT_NEAR(*diagnosis.verdict.detected_at_s, 10.0, 0.031);
  EXPECT_NEAR(*diagnosis.verdict.onset_s, 10.0, 0.02);
}

TEST(Pipeline, UsesAStoredCalibrationFromTheFirstSampleOn) {
  const Diagnosis first = DiagnoseRecord(BenchRecord({}, 33), FreeValues(Channels::kAll));
  ASSERT_TRUE(first.calibration.has_value());
  DiagnosisOptions options = FreeValues(Channels::kAll);
  options.calibration = first.calibration;
  const Diagnosis second =
      DiagnoseRecord(BenchRecord({AbruptFault(paper::kC8, 10e-6, 2.0)}, 34, 6.0), options);
  EXPECT_EQ(second.verdict.group, std::vector<Component>{paper::kC8}) << second.verdict.reason;
  EXPECT_NEAR(*second.verdict.onset_s, 2.0, 0.02);
}

}  // namespace
}  // namespace faultlab::core
