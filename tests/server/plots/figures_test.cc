#include "server/plots/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "hardware/bench/benches.h"
#include "server/csv/csv_record.h"
#include "server/plots/comparison_figure.h"
#include "server/plots/record_figure.h"
#include "server/plots/sweep_figure.h"
#include "tests/paper_rig.h"
#include "tests/support/paths.h"

namespace faultlab::server {
namespace {

using ::testing::HasSubstr;

CsvRecord Recording() {
  core::Result<CsvRecord> record = ReadCsv(tests::InSource("tests/data/r1_33ohm.csv.gz"));
  EXPECT_TRUE(record) << record.error().message;
  return std::move(record).value();
}

FigureContext Context() {
  FigureContext context;
  context.name = "R1";
  context.faults = {{paper::kR1, 33.0, 10.0}};
  return context;
}

TEST(SignalsFigure, ShowsTheChannelsThatTheRecordingHas) {
  const CsvRecord record = Recording();
  const Figure figure = MakeSignalsFigure(record.samples, Context());
  ASSERT_EQ(figure.panels.size(), 4u);
  EXPECT_EQ(figure.panels[0].y.label, "U_{c}");
  EXPECT_TRUE(figure.panels[0].series[0].stair);
  ASSERT_TRUE(figure.panels[0].inset) << "the magnified PRBS of Figure 14";
  EXPECT_EQ(figure.panels[3].y.unit, "rpm");
  EXPECT_EQ(figure.panels[1].series[0].y.size(), record.samples.size());
  ASSERT_EQ(figure.marks.size(), 1u);
  EXPECT_EQ(figure.marks[0].x, 10.0);
  EXPECT_EQ(figure.marks[0].label, "R_{1} = 33 Ω");

  std::vector<core::Sample> bare = record.samples;
  for (core::Sample& sample : bare) {
    sample.ia_a = sample.n_rpm = core::kAbsent;
  }
  EXPECT_EQ(MakeSignalsFigure(bare, Context()).panels.size(), 2u);
}

TEST(SignalsFigure, BreaksTheLineWhereSamplesAreMissing) {
  std::vector<core::Sample> samples(3);
  for (int k = 0; k < 3; ++k) {
    samples[static_cast<std::size_t>(k)].index = k == 2 ? 5 : k;
    samples[static_cast<std::size_t>(k)].t_s = k == 2 ? 0.05 : 0.01 * k;
    samples[static_cast<std::size_t>(k)].um_v = 1.0;
  }
  const Figure figure = MakeSignalsFigure(samples, {});
  const std::vector<double>& y = figure.panels[1].series[0].y;
  ASSERT_EQ(y.size(), 4u);
  EXPECT_TRUE(std::isnan(y[2]));
}

TEST(EstimatesFigure, ShadesTheTransientOfEachWindow) {
  const CsvRecord record = Recording();
  std::vector<core::Frame> frames;
  for (const core::Sample& sample : record.samples) {
    frames.push_back({sample, {}});
  }
  constexpr double kTolerance = 1e-9;
  const Figure swa = MakeEstimatesFigure(frames, EstimatorFamily::kSwa, Context());
  ASSERT_EQ(swa.panels[0].bands.size(), 3u);
  EXPECT_NEAR(*swa.panels[0].bands[0].x_to, 10.49, kTolerance);
  EXPECT_NEAR(*swa.panels[0].bands[1].x_to, 10.99, kTolerance);
  EXPECT_NEAR(*swa.panels[0].bands[2].x_to, 11.99, kTolerance);
  const Figure sia = MakeEstimatesFigure(frames, EstimatorFamily::kSia, Context());
  EXPECT_NEAR(*sia.panels[0].bands[0].x_to, 10.24, kTolerance);
  EXPECT_NEAR(*sia.panels[0].bands[1].x_to, 11.19, kTolerance);
  EXPECT_NEAR(*sia.panels[0].bands[2].x_to, 15.19, kTolerance);
}

core::Verdict FoundR1(double value, std::vector<double> at_s) {
  core::Verdict verdict;
  verdict.kind = core::VerdictKind::kFault;
  verdict.detected_at_s = at_s.front();
  verdict.onset_s = at_s.front() - 0.02;
  for (std::size_t i = 1; i < at_s.size(); ++i) {
    verdict.further.push_back({at_s[i], at_s[i] - 0.02, "residual"});
  }
  verdict.group = {paper::kR1};
  verdict.candidates = {{paper::kR1, value, 0.1, 0, 1.0, 0.0}};
  return verdict;
}

TEST(Marks, ShowEveryChangeAndEveryDetectionOfAFault) {
  FigureContext context;
  context.faults = {{paper::kR1, 33.0, 8.0}, {paper::kR1, 100.0, 14.0}, {paper::kR1, 1.0, 18.0}};
  context.episodes = {{FoundR1(99.8, {8.03, 14.05}), core::FaultShape::kAbrupt, 18.07}};
  const Figure figure = MakeSignalsFigure({}, context);
  std::vector<std::string> told;
  for (const Mark& mark : figure.marks) told.push_back(mark.label);
  EXPECT_THAT(told,
              ::testing::ElementsAre("R_{1} = 33 Ω",
                                     "R_{1} = 100 Ω",
                                     "R_{1} nominal",
                                     "detected +0.03 s",
                                     "detected +0.05 s: R_{1} = 99.8 Ω",
                                     "detected +0.07 s: nominal"));
  EXPECT_EQ(figure.marks[2].kind, MarkKind::kReturned);
  EXPECT_EQ(figure.marks[4].x, 14.05);
}

TEST(EstimatesFigure, ShadesTheTransientOfEveryChange) {
  std::vector<core::Frame> frames(2000);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].sample.index = static_cast<std::int64_t>(k);
    frames[k].sample.t_s = 0.01 * static_cast<double>(k);
  }
  FigureContext context;
  context.episodes = {{FoundR1(99.8, {8.02, 14.02}), core::FaultShape::kAbrupt, std::nullopt}};
  const Figure swa = MakeEstimatesFigure(frames, EstimatorFamily::kSwa, context);
  ASSERT_EQ(swa.panels[0].bands.size(), 6U);
  EXPECT_NEAR(*swa.panels[0].bands[3].x_from, 14.0, 1e-9);
  EXPECT_FALSE(swa.panels[0].bands[0].name.empty());
  EXPECT_TRUE(swa.panels[0].bands[3].name.empty()) << "one entry in the legend";
}

/// The fits compare the newest model with what was measured since the newest change.
TEST(CompareModels, FollowsTheNewestChangeOfAFault) {
  const CsvRecord record = Recording();
  core::DiagnosisOptions options = core::OptionsOf(hardware::PaperBench());
  core::Diagnosis diagnosis;
  diagnosis.verdict = FoundR1(33.0, {10.02});
  EXPECT_NEAR(CompareModels(record.samples, options, diagnosis).t_s.front(), 10.0, 1e-6);
  diagnosis.verdict = FoundR1(33.0, {10.02, 15.02});
  EXPECT_NEAR(CompareModels(record.samples, options, diagnosis).t_s.front(), 15.0, 1e-6);
  diagnosis.verdict = {};
  diagnosis.episodes = {{FoundR1(33.0, {8.02}), core::FaultShape::kAbrupt, 12.0}};
  EXPECT_NEAR(CompareModels(record.samples, options, diagnosis).t_s.front(), 12.0, 1e-6)
      << "nominal again";
}

TEST(ModelsFigure, NamesWhatIsPresentInItsStretch) {
  FigureContext context;
  context.faults = {{paper::kR1, 33.0, 8.0}, {paper::kR1, 1.0, 12.0}, {paper::kR12, 5600.0, 14.0}};
  ModelComparison comparison;
  for (int k = 0; k < 300; ++k) {
    comparison.t_s.push_back(14.0 + 0.01 * k);
    comparison.y.push_back(5.0);
  }
  EXPECT_EQ(MakeModelsFigure(comparison, context).subtitle, "R_{12} = 5.6 kΩ");
}

TEST(EstimatesFigure, LeavesAGapWhereThereIsNoEstimate) {
  std::vector<core::Frame> frames(4);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].sample.index = static_cast<std::int64_t>(k);
    frames[k].sample.t_s = 0.01 * static_cast<double>(k);
    for (core::Estimate<3>& estimate : frames[k].estimates) {
      estimate.theta = {1.0, 2.0, 3.0};
      estimate.sigma = {0.1, 0.1, 0.1};
      estimate.status = core::EstimateStatus::kExcited;
    }
  }
  frames[1].estimates[0].status = core::EstimateStatus::kNotExcited;
  frames[2].estimates[0].age_samples = 1;
  frames[3].estimates[0].sigma[2] = INFINITY;
  const Figure figure = MakeEstimatesFigure(frames, EstimatorFamily::kSwa, {});
  const std::vector<double>& b0 = figure.panels[0].series[0].y;
  EXPECT_EQ(b0[0], 1.0);
  EXPECT_TRUE(std::isnan(b0[1])) << "a held value is not an estimate of this sample";
  EXPECT_TRUE(std::isnan(b0[2]));
  EXPECT_EQ(b0[3], 1.0);
  EXPECT_TRUE(std::isnan(figure.panels[1].series[0].y[3])) << "a bound is no point";
}

TEST(ModelsFigure, PutsTheFitIntoTheLegendAndTheErrorBelow) {
  ModelComparison comparison;
  for (int k = 0; k < 500; ++k) {
    comparison.t_s.push_back(10.0 + 0.01 * k);
    comparison.y.push_back(std::sin(0.3 * k));
  }
  comparison.models.push_back({"swa", "SWA", 98.64, comparison.y});
  comparison.models[0].y[0] -= 0.25;
  const Figure figure = MakeModelsFigure(comparison, Context());
  ASSERT_EQ(figure.panels.size(), 2u);
  EXPECT_EQ(figure.panels[0].series[1].name, "SWA  98.6 %");
  EXPECT_EQ(figure.panels[0].series[0].x.size(), 201u) << "2 s are shown";
  EXPECT_EQ(figure.panels[1].series[0].y[0], 0.25);
}

TEST(ComparisonFigure, PutsTheChangeOfEachRecordAtZero) {
  std::vector<ComparedRecord> records(2);
  for (int r = 0; r < 2; ++r) {
    ComparedRecord& record = records[static_cast<std::size_t>(r)];
    record.name = r == 0 ? "first" : "second";
    record.zero_s = 1.0 + r;
    record.curve = EmptyCurve(core::EstimatorId::kSia100x20);
    for (int k = 0; k < 300; ++k) {
      core::Frame frame{};
      frame.sample.index = k;
      frame.sample.t_s = 0.01 * k;
      frame.sample.um_v = r;
      Append(frame, core::EstimatorId::kSia100x20, record.curve);
      record.samples.push_back(frame.sample);
    }
  }
  const Figure figure = MakeComparisonFigure(records, EstimatorFamily::kSia, true, "");
  ASSERT_EQ(figure.panels.size(), 4u);
  EXPECT_EQ(figure.panels[0].series[0].name, "first");
  EXPECT_NEAR(figure.panels[0].series[1].x.front(), -2.0, 1e-9);
  EXPECT_NEAR(figure.panels[1].series[0].x.front(), -1.0, 1e-9);
  EXPECT_NE(figure.panels[0].series[0].dash, figure.panels[0].series[1].dash);
  EXPECT_EQ(figure.panels[0].series[1].ink, figure.panels[3].series[1].ink);
  ASSERT_TRUE(figure.x.range);
  EXPECT_NEAR(figure.x.range->first, -2.0, 1e-9);
  EXPECT_NEAR(figure.x.range->second, 2.0, 1e-9);
  ASSERT_EQ(figure.marks.size(), 1u);
  EXPECT_EQ(figure.marks[0].x, 0.0);
  EXPECT_TRUE(MakeComparisonFigure(records, EstimatorFamily::kSia, false, "").marks.empty());
}

TEST(SweepFigure, CountsWhatWasNamedOfEachFault) {
  const SweepRun right{.component = paper::kR1,
                       .value = 100.0,
                       .named = {paper::kR1},
                       .found = 98.0,
                       .delay_s = 0.4};
  const SweepRun group{.component = paper::kR9,
                       .value = 6e4,
                       .named = {paper::kR9, paper::kR12},
                       .found = 1.0,
                       .delay_s = 0.2};
  const SweepRun missed{.component = paper::kR1, .value = 100.0};
  const SweepRun healthy{};
  const std::vector<SweepRun> runs = {right, missed, group, healthy};
  const std::vector<core::Component> components = {paper::kR1, paper::kR9, paper::kR12};
  const CellMatrix matrix = MakeSweepFigure(runs, components, "", "").matrix;
  EXPECT_THAT(matrix.rows, testing::ElementsAre("R_{1} = 100 Ω (2)", "R_{9} = 60 kΩ", "healthy"));
  EXPECT_THAT(matrix.text,
              testing::ElementsAre("50 %",
                                   "",
                                   "",
                                   "",
                                   "50 %",
                                   "0.40",
                                   "2.0",
                                   "",
                                   "50 %",
                                   "50 %",
                                   "",
                                   "",
                                   "0.20",
                                   "",
                                   "",
                                   "",
                                   "",
                                   "",
                                   "100 %",
                                   "",
                                   ""));
}

TEST(SweepFigure, OfManyFaultsHasARowForEachComponent) {
  std::vector<SweepRun> runs(kSweepRowsMax + 1);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].component = paper::kR1;
    runs[i].value = 20.0 + static_cast<double>(i);
  }
  const std::vector<core::Component> components = {paper::kR1};
  EXPECT_THAT(MakeSweepFigure(runs, components, "", "").matrix.rows,
              testing::ElementsAre("R_{1} (31)"));
}

TEST(RecordFigure, DrawsEveryFigureOfARecordingByName) {
  const CsvRecord record = Recording();
  core::DiagnosisOptions options = paper::Options();
  options.values = core::ValuePrior::kTable2;
  options.period_s = record.period_s;
  for (const std::string_view name : kFigureNames) {
    const core::Result<Figure> figure = MakeFigure(name, record.samples, options, Context());
    ASSERT_TRUE(figure) << name << ": " << figure.error().message;
    const bool flows = name == "steps" || name == "decisions";
    EXPECT_EQ(figure.value().panels.empty(), flows) << name;
    EXPECT_EQ(figure.value().flow.empty(), !flows) << name;
  }
  const core::Result<Figure> unknown = MakeFigure("spectrum", record.samples, options, Context());
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().message,
            "unknown figure 'spectrum', expected one of signals, swa, sia, models, friction, "
            "steps, decisions");
  EXPECT_THAT(MakeFigure("swa", {}, options, Context()).error().message,
              HasSubstr("at least two samples"));
}

/// The steps of Figure 6 that a run went through: a healthy one ends at "no fault".
TEST(RecordFigure, ShowsHowFarARunWentThroughTheStepsOfThePaper) {
  core::DiagnosisOptions options = paper::Options();
  options.values = core::ValuePrior::kTable2;
  const std::vector<double> uc_v = core::MakePrbs({}, 1500, paper::kPeriodS);
  const core::Fault fault = {.component = *options.bench->Find("C8"), .value = 10e-6, .at_s = 8.0};
  const auto taken = [&](const std::vector<core::Fault>& faults) {
    const std::vector<core::Sample> samples = core::SimulateRecord(
        paper::Hardware(), options.bench->nominal, uc_v, faults, 1, paper::kPeriodS);
    std::vector<bool> steps;
    const Figure figure = MakeFigure("steps", samples, options, Context()).value();
    for (const FlowStep& step : figure.flow) steps.push_back(step.taken);
    return steps;
  };
  EXPECT_EQ(taken({fault}), (std::vector<bool>{true, true, true, false, true, true}));
  EXPECT_EQ(taken({}), (std::vector<bool>{true, true, true, true, false, false}));
}

TEST(FrictionFigure, MeasuresTheFrictionThatTheRigHas) {
  core::DiagnosisOptions options = paper::Options();
  options.values = core::ValuePrior::kTable2;
  const std::vector<double> uc_v = core::MakePrbs({}, 2000, paper::kPeriodS);
  const std::vector<core::Fault> faults = {
      {.component = *options.bench->Find("B"), .value = 1.8e-4, .at_s = 10.0}};
  const std::vector<core::Sample> samples = core::SimulateRecord(
      paper::Hardware(), options.bench->nominal, uc_v, faults, 1, paper::kPeriodS);
  const Figure figure = MakeFigure("friction", samples, options, Context()).value();
  ASSERT_EQ(figure.panels.size(), 1U);
  EXPECT_TRUE(figure.marks.empty());
  const std::vector<Series>& lines = figure.panels.front().series;
  ASSERT_EQ(lines.size(), 5U);
  // mN m per rad/s between the ends of a line.
  const auto slope = [](const Series& line) {
    double first = NAN, last = NAN, from = NAN, to = NAN;
    for (std::size_t i = 0; i < line.x.size(); ++i) {
      if (!std::isfinite(line.y[i])) continue;
      if (!std::isfinite(first)) std::tie(first, from) = std::pair(line.y[i], line.x[i]);
      std::tie(last, to) = std::pair(line.y[i], line.x[i]);
    }
    return (last - first) / (to - from);
  };
  EXPECT_THAT(lines[0].name, HasSubstr("measured before"));
  EXPECT_THAT(lines[1].name, HasSubstr("measured after"));
  EXPECT_NEAR(slope(lines[1]), 0.18, 0.03) << "B is 0.18 uN m per rad/s and more";
  EXPECT_EQ(lines[3].name, "simulators, as described");
  EXPECT_GT(*std::ranges::max_element(lines[3].y), 0.39) << "static friction, as the motor begins";
  EXPECT_NEAR(slope(lines[4]), 0.18, 0.01) << "as found";
  EXPECT_LT(slope(lines[0]), 0.02);
}

}  // namespace
}  // namespace faultlab::server
