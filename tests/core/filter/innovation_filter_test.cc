#include "core/filter/innovation_filter.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/filter/riccati_recursion.h"
#include "core/filter/simd/lane_products.h"
#include "core/filter/simd/lane_run.h"
#include "core/signals/random.h"
#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

RigParameters BenchRig() {
  RigParameters rig = paper::Rig();
  rig.mc_nm = 0.33e-3;
  return rig;
}

NoiseLevel BenchNoise() {
  NoiseLevel noise = paper::Noise();
  noise.w_rad_s = 0.5 * paper::kRadPerSecondOfRpm;
  return noise;
}

// A stretch with a fault, missing readings, missing samples, and um at a rail.
std::vector<Observation> EventfulStretch(double um_rail_v) {
  std::vector<Sample> record = BenchRecord({AbruptFault(paper::kRa, 5.0, 4.0)}, 43, 8.0);
  for (std::size_t k = 150; k < 170; ++k) record[k].ia_a = kAbsent;
  for (std::size_t k = 330; k < 340; ++k) record[k].um_v = kAbsent;
  for (std::size_t k = 600; k < 605; ++k) record[k].n_rpm = kAbsent;
  record.erase(record.begin() + 500, record.begin() + 520);
  return MakeObservations(record, paper::Bench().readings(), Channels::kAll, 0.01, um_rail_v);
}

// Models so different that their gains settle at different samples. The supply of every second one
// ends at `output_max_v`.
std::vector<PredictionModel> DifferentModels(double output_max_v) {
  std::vector<PredictionModel> models;
  const auto add = [&](Component component, double value) {
    RigParameters rig = BenchRig();
    rig.plant.Set(component, value);
    if (models.size() % 2 == 1) rig.plant.range.output_max_v = output_max_v;
    models.push_back(MakePredictionModel(rig, BenchNoise(), 0.01));
  };
  add(paper::kR1, 1.0);
  add(paper::kR1, 100.0);
  add(paper::kC8, 47e-6);
  add(paper::kRa, 60.0);
  add(paper::kJ, 1e-4);
  add(paper::kJ, 2e-8);
  add(paper::kR9, 33e3);
  return models;
}

void ExpectTheBitsOfEachAlone(const std::vector<Observation>& stretch,
                              double output_max_v = kNoEnd) {
  const std::vector<PredictionModel> models = DifferentModels(output_max_v);
  // Twenty paths, more than step together; each changes its model at another sample.
  std::vector<std::vector<ModelSegment>> segments;
  std::vector<ModelPath> paths;
  for (std::size_t i = 0; i < 20; ++i) {
    segments.push_back({{0, &models[i % models.size()]}});
    if (i % 3 != 0) {
      segments.back().push_back({90 + 17 * i, &models[(i + 2) % models.size()], i % 2 == 0});
    }
  }
  for (const auto& path : segments) paths.emplace_back(path);
  std::vector<InnovationSummary> sums(paths.size());
  std::vector<InnovationSummary> with_mc(paths.size());
  InnovationTable table;
  RunInnovations(paths, stretch, sums, &table);
  RunWithMcResponse(paths, stretch, with_mc);
  // Two to a register, on any processor.
  std::vector<InnovationSummary> narrow(kPathsTogether);
  LaneRun pairs{std::span<const ModelPath>(paths).first(kPathsTogether),
                stretch,
                {},
                narrow,
                output_max_v < kNoEnd};
  InnovationTable narrow_table(table.rows(), kPathsTogether);
  pairs.table = narrow_table.data();
  pairs.stride = kPathsTogether;
  RunLanes<Lanes2, false>(pairs);
  EXPECT_TRUE((narrow_table.array() == table.leftCols(kPathsTogether).array()).all());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto one = std::span<const ModelPath>(paths).subspan(i, 1);
    std::array<InnovationSummary, 1> alone;
    InnovationTable column;
    RunInnovations(one, stretch, alone, &column);
    EXPECT_EQ(sums[i].chi2, alone[0].chi2) << i;
    EXPECT_EQ(sums[i].log_det, alone[0].log_det) << i;
    EXPECT_EQ(sums[i].count_of, alone[0].count_of) << i;
    ASSERT_EQ(table.rows(), column.rows());
    EXPECT_TRUE((table.col(static_cast<Eigen::Index>(i)).array() == column.col(0).array()).all())
        << i;
    std::array<InnovationSummary, 1> alone_with_mc;
    RunWithMcResponse(one, stretch, alone_with_mc);
    EXPECT_EQ(with_mc[i].chi2, alone[0].chi2) << i;
    EXPECT_EQ(with_mc[i].mc_cross, alone_with_mc[0].mc_cross) << i;
    EXPECT_EQ(with_mc[i].mc_square, alone_with_mc[0].mc_square) << i;
  }
}

TEST(InnovationFilter, LeavesWhiteUnitInnovationsOfAHealthyBench) {
  RigParameters rig = paper::Rig();
  rig.mc_nm = 0.33e-3;
  const auto record = Between(BenchRecord({}, 41), 0.5, 20.0);
  const auto stretch =
      MakeObservations(record, paper::Bench().readings(), Channels::kAll, 0.01, 10.0);
  InnovationTrace trace;
  NoiseLevel noise = paper::Noise();
  noise.w_rad_s = 0.5 * paper::kRadPerSecondOfRpm;
  const InnovationSummary sum =
      RunInnovations(MakePredictionModel(rig, noise, 0.01), stretch, &trace);
  ASSERT_EQ(sum.count, 3 * 1950);
  // 5850 readings: chi2/n has a standard deviation of 1.8 %.
  EXPECT_NEAR(sum.chi2 / sum.count, 1.0, 0.12);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    double lag = 0.0;
    double energy = 0.0;
    for (std::size_t k = 20; k < stretch.size(); ++k) {
      const double now = trace.whitened[3 * k + channel];
      lag += now * trace.whitened[3 * (k - 1) + channel];
      energy += now * now;
    }
    // 1900 samples: sd 2.3 %.
    EXPECT_LT(std::abs(lag / energy), 0.1) << channel;
  }
}

TEST(InnovationFilter, ForgetsWhereItStarted) {
  // After a gap of unknown length the same stretch may cost at most the first samples.
  const auto record = Between(BenchRecord({}, 42), 0.5, 8.0);
  RigParameters rig = paper::Rig();
  rig.mc_nm = 0.33e-3;
  const PredictionModel model = MakePredictionModel(rig, paper::Noise(), 0.01);
  std::vector<Sample> cut = record;
  cut.erase(cut.begin() + 300, cut.begin() + 340);
  const auto whole =
      MakeObservations(record, paper::Bench().readings(), Channels::kUmOnly, 0.01, 10.0);
  const auto gapped =
      MakeObservations(cut, paper::Bench().readings(), Channels::kUmOnly, 0.01, 10.0);
  EXPECT_TRUE(gapped[300].restart);
  const double n = static_cast<double>(gapped.size());
  EXPECT_NEAR(RunInnovations(model, gapped).chi2 / n,
              RunInnovations(model, whole).chi2 / static_cast<double>(whole.size()),
              0.1);
}

TEST(InnovationFilter, GivesModelsSideBySideTheBitsThatEachGetsAlone) {
  ExpectTheBitsOfEachAlone(EventfulStretch(10.0));
}

TEST(InnovationFilter, GivesModelsSideBySideTheBitsThatEachGetsAloneAtTheRail) {
  const std::vector<Observation> stretch = EventfulStretch(6.9);
  const auto clipped = [](const Observation& o) { return o.clipped != 0; };
  ASSERT_GT(std::count_if(stretch.begin(), stretch.end(), clipped), 100);
  ExpectTheBitsOfEachAlone(stretch);
}

TEST(InnovationFilter, GivesModelsSideBySideTheBitsThatEachGetsAloneWhereTheSupplyOfSomeEnds) {
  // A healthy output is twice the input, which switches between 2 V and 3 V.
  ExpectTheBitsOfEachAlone(EventfulStretch(10.0), 5.0);
}

TEST(InnovationFilter, IsTheTextbooksKalmanFilterWithGainsThatAreHeldWhenTheyHaveSettled) {
  const auto stretch = MakeObservations(
      BenchRecord({}, 44, 6.0), paper::Bench().readings(), Channels::kAll, 0.01, 10.0);
  for (const PredictionModel& model : DifferentModels(kNoEnd)) {
    InnovationTrace trace;
    RunInnovations(model, stretch, &trace);
    RiccatiRecursion recursion(model);
    recursion.Restart();
    const Eigen::Matrix4d away = Eigen::Matrix4d::Identity() - model.phi;
    Eigen::Vector4d x = away.partialPivLu().solve((model.g_prev + model.g) * stretch[0].u +
                                                  model.g_torque * model.mc_nm);
    std::array<Eigen::Vector4d, kOutputCount> gain;
    std::array<double, kOutputCount> s{};
    int quiet = 0;
    double worst = 0.0;
    double largest = 1.0;
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      const Observation& o = stretch[k];
      const bool held = quiet >= 6;
      if (k > 0) {
        const double sign = std::clamp(x(2) / model.creep_rad_s, -1.0, 1.0);
        const Eigen::Vector4d next = model.phi * x + model.g_prev * o.u_prev + model.g * o.u +
                                     model.g_torque * (sign * model.mc_nm);
        x = next;
        if (!held) recursion.Predict();
      }
      bool moved = false;
      for (int channel = 0; channel < kOutputCount; ++channel) {
        const auto c = static_cast<std::size_t>(channel);
        if (!held) {
          const double before = s[c];
          s[c] = recursion.Correct(channel, gain[c]);
          moved = moved || std::abs(s[c] - before) > 2e-4 * s[c];
        }
        const double e = o.y[c] - model.c.row(channel).dot(x) - model.d(channel) * o.u;
        x += gain[c] * e;
        const double z = e / std::sqrt(s[c]);
        largest = std::max(largest, std::abs(z));
        worst = std::max(worst, std::abs(z - trace.whitened[k * kOutputCount + c]));
      }
      if (!held) quiet = moved ? 0 : quiet + 1;
    }
    EXPECT_GE(quiet, 6);
    // Rounding error of a covariance that falls by eight orders of magnitude.
    EXPECT_LT(worst, 1e-6 * largest);
  }
}

TEST(LaneProducts, AreTheProductsOfSlopesAndPoint) {
  Random random(7);
  for (Eigen::Index n : {8, 9, 10, 11, 12, 13, 14}) {
    const std::size_t columns = PaddedColumns(static_cast<std::size_t>(n + 1));
    InnovationTable table(333, static_cast<Eigen::Index>(columns));
    for (double& value : table.reshaped()) value = random.Normal();
    InnovationTable v = table.leftCols(n + 1);
    v.leftCols(n) = (table.leftCols(n).colwise() - table.col(n)) * 1e5;
    const Eigen::MatrixXd expected = v.transpose() * v;
    const ProductRows rows{table.data(), 333, columns, static_cast<std::size_t>(n), 1e5};
    ProductSums widest;
    ProductSums pairs;
    SumProducts(rows, widest);
    SumLaneProducts<Lanes2>(rows, pairs);
    for (Eigen::Index i = 0; i <= n; ++i) {
      for (Eigen::Index j = i; j <= n; ++j) {
        const auto a = static_cast<std::size_t>(i);
        const auto b = static_cast<std::size_t>(j);
        EXPECT_EQ(widest[a][b], pairs[a][b]);
        EXPECT_NEAR(
            pairs[a][b], expected(i, j), 1e-11 * std::sqrt(expected(i, i) * expected(j, j)));
      }
    }
  }
}

// S is large for some samples after a gap; that of nearly all readings is the settled one.
TEST(InnovationFilter, CountsTheSettledVarianceWhereTheRecordEndsJustAfterAGap) {
  auto record = BenchRecord({}, 46, 6.0);
  const PredictionModel model = MakePredictionModel(BenchRig(), BenchNoise(), 0.01);
  const auto log_det_of = [&](std::size_t samples_after_gap) {
    auto with_gap = record;
    with_gap.erase(with_gap.end() - static_cast<std::ptrdiff_t>(samples_after_gap) - 1);
    const auto stretch =
        MakeObservations(with_gap, paper::Bench().readings(), Channels::kAll, 0.01, 10.0);
    EXPECT_TRUE(stretch[stretch.size() - samples_after_gap].restart);
    return RunInnovations(model, stretch).log_det;
  };
  const double settled = log_det_of(200);
  for (const std::size_t after : {1, 2, 5}) EXPECT_NEAR(log_det_of(after), settled, 0.5) << after;
  // A channel that was silent until the gap has no settled one.
  for (std::size_t k = 0; k + 2 < record.size(); ++k) record[k].n_rpm = kAbsent;
  EXPECT_TRUE(std::isfinite(log_det_of(1)));
}

TEST(InnovationFilter, TellsTheResponseToMcOfAMotorThatTurnsOneWay) {
  const auto record = BenchRecord({}, 45, 6.0);
  const auto stretch = MakeObservations(std::span<const Sample>(record).subspan(100),
                                        paper::Bench().readings(),
                                        Channels::kUmOnly,
                                        0.01,
                                        10.0);
  RigParameters rig = BenchRig();
  const auto sum_of = [&] {
    const PredictionModel model = MakePredictionModel(rig, BenchNoise(), 0.01);
    const ModelSegment only{0, &model};
    const ModelPath path(&only, 1);
    InnovationSummary sum;
    RunWithMcResponse(
        std::span<const ModelPath>(&path, 1), stretch, std::span<InnovationSummary>(&sum, 1));
    return sum;
  };
  const InnovationSummary here = sum_of();
  const double m = 0.1e-3;
  rig.mc_nm += m;
  const double told = here.chi2 - 2.0 * m * here.mc_cross + m * m * here.mc_square;
  EXPECT_GT(std::abs(told - here.chi2), 10.0);
  EXPECT_NEAR(sum_of().chi2, told, 0.02 * std::abs(told - here.chi2));
}

TEST(Innovations, ReadingThatIsTrustedLessCountsLessAndCorrectsTheStateAllTheSame) {
  const auto record = BenchRecord({}, 47, 4.0);
  auto stretch = MakeObservations(record, paper::Bench().readings(), Channels::kAll, 0.01, 10.0);
  const PredictionModel model = MakePredictionModel(BenchRig(), BenchNoise(), 0.01);
  InnovationTrace whole;
  RunInnovations(model, stretch, &whole);
  stretch[200].trust = {0.5, 1.0, 0.25};
  InnovationTrace trusted;
  RunInnovations(model, stretch, &trusted);
  for (std::size_t at = 0; at < whole.whitened.size(); ++at) {
    const double share = at / kOutputCount == 200 ? stretch[200].trust[at % kOutputCount] : 1.0;
    EXPECT_DOUBLE_EQ(trusted.whitened[at], share * whole.whitened[at]) << at;
  }
}

TEST(ReadingTrust, CountsTheTimeSinceAStepWhateverTheRate) {
  ModelError error;
  error.step_v = 1.0;
  error.growth[1] = {8.0, 4.0, 2.0, 1.0, 1.0, 1.0, 1.0};
  for (const double period_s : {0.02, 0.01, 0.001}) {
    const auto samples = static_cast<std::size_t>(std::max(1.0, 0.01 / period_s));
    std::vector<Observation> stretch(8 * samples);
    stretch[2 * samples].u = 3.0;  // from 0
    GiveTrust(error, period_s, stretch);
    const std::vector<double> of = {1.0, 1.0, 1.0 / 8, 1.0 / 4, 1.0 / 2, 1.0 / 2, 1.0, 1.0};
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      EXPECT_DOUBLE_EQ(stretch[k].trust[1], of[k / samples]) << period_s << ' ' << k;
      EXPECT_DOUBLE_EQ(stretch[k].trust[0], 1.0);
    }
  }
}

}  // namespace
}  // namespace faultlab::core
