#include "server/plots/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/csv/csv_record.h"
#include "server/plots/record_figure.h"
#include "tests/paper_rig.h"

namespace faultlab::server {
namespace {

using ::testing::HasSubstr;

CsvRecord Recording() {
  core::Result<CsvRecord> record = ReadCsv(FAULTLAB_TEST_DATA "/r1_33ohm.csv.gz");
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

TEST(RecordFigure, DrawsEveryFigureOfARecordingByName) {
  const CsvRecord record = Recording();
  core::DiagnosisOptions options = paper::Options();
  options.values = core::ValuePrior::kTable2;
  options.period_s = record.period_s;
  for (const std::string_view name : kFigureNames) {
    const core::Result<Figure> figure = MakeFigure(name, record.samples, options, Context());
    ASSERT_TRUE(figure) << name << ": " << figure.error().message;
    EXPECT_FALSE(figure.value().panels.empty()) << name;
  }
  const core::Result<Figure> unknown = MakeFigure("spectrum", record.samples, options, Context());
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().message,
            "unknown figure 'spectrum', expected one of signals, swa, sia, models");
  EXPECT_THAT(MakeFigure("swa", {}, options, Context()).error().message,
              HasSubstr("at least two samples"));
}

}  // namespace
}  // namespace faultlab::server
