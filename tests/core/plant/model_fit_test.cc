#include "core/plant/model_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/plant/plant.h"
#include "core/signals/prbs.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.01;
constexpr double kPerfect = 1e-6;  // percent: rounding of a least squares over 500 samples

TEST(FitPercent, IsTheFormulaOfMatlabsCompare) {
  // y = 1, 2, 3, 4: |y - mean| = sqrt 5; yhat off by 0.5 everywhere: |e| = 1.
  EXPECT_NEAR(CompareFit(std::vector{1.0, 2.0, 3.0, 4.0}, std::vector{1.5, 2.5, 3.5, 4.5}),
              100.0 * (1.0 - 1.0 / std::sqrt(5.0)),
              1e-12);
}

TEST(FitPercent, PerfectIsHundredMeanIsZeroWorseIsNegative) {
  const std::vector<double> y = {1.0, 2.0, 3.0};
  EXPECT_EQ(CompareFit(y, y), 100.0);
  EXPECT_NEAR(CompareFit(y, std::vector{2.0, 2.0, 2.0}), 0.0, 1e-12);
  EXPECT_LT(CompareFit(y, std::vector{3.0, 2.0, 1.0}), 0.0);
}

TEST(FitPercent, SaysSoWhenThereIsNoAnswer) {
  EXPECT_TRUE(std::isnan(CompareFit(std::vector{1.0, 1.0}, std::vector{1.0, 2.0})));
  EXPECT_TRUE(std::isnan(CompareFit(std::vector{1.0, 2.0}, std::vector{1.0})));
  EXPECT_TRUE(std::isnan(CompareFit(std::vector<double>{}, std::vector<double>{})));
  EXPECT_TRUE(std::isnan(CompareFit(std::vector{1.0, std::nan("")}, std::vector{1.0, 2.0})));
}

TEST(ModelFit, FindsTheInitialStateOfADiscreteModel) {
  const DiscreteCoefficients model{2.1, -1.1, -0.95};  // slow: the initial state matters
  const std::vector<double> uc_v = MakePrbs({}, 500, kPeriodS);
  std::vector<double> um_v;
  double y = 30.0;
  double u = 1.0;
  for (const double next : uc_v) {
    y = model.b0d * next + model.b1d * u - model.a1d * y;
    u = next;
    um_v.push_back(y);
  }
  EXPECT_NEAR(FitDiscrete(model, uc_v, um_v).fit_percent, 100.0, kPerfect);
}

TEST(ModelFit, AnUnstableOrImpossibleModelIsNotAFit) {
  const std::vector<double> uc_v = MakePrbs({}, 2000, kPeriodS);
  EXPECT_TRUE(std::isnan(FitDiscrete({2.0, -1.0, -3.0}, uc_v, uc_v).fit_percent));
  EXPECT_TRUE(std::isnan(
      FitContinuous({.b0 = 2.0, .b1 = 0.1, .a1 = -0.1}, uc_v, uc_v, kPeriodS, 0.0).fit_percent));
}

// The plant itself, turning and without noise, compared with its models.
struct Recording {
  std::vector<double> uc_v;
  std::vector<double> um_v;
};

Recording Record(const PlantParameters& p,
                 const BenchProfile& profile,
                 std::vector<double> uc_v = MakePrbs({}, 500, kPeriodS)) {
  Plant plant(p, profile, 1);
  plant.SetInput(2.5);
  plant.Advance(0.5);
  Recording recording;
  recording.uc_v = std::move(uc_v);
  for (const double uc : recording.uc_v) {
    plant.SetInput(uc);
    plant.Advance(profile.delta_s);
    recording.um_v.push_back(plant.outputs().um_v);
    plant.Advance(kPeriodS - profile.delta_s);
  }
  return recording;
}

BenchProfile QuietBench() {
  BenchProfile profile = paper::Hardware();
  profile.friction.noise_rms_nm = 0.0;
  return profile;
}

class EveryComponent : public testing::TestWithParam<Component> {};
INSTANTIATE_TEST_SUITE_P(Models, EveryComponent, testing::ValuesIn(paper::Parts()));

TEST_P(EveryComponent, SampledModelIsThePlantToTheLastDigit) {
  PlantParameters p = paper::Plant();
  const double factor = GetParam() == paper::kC8    ? 1e5
                        : GetParam() == paper::kR12 ? 0.3  // 3 reaches the supply
                                                    : 3.0;
  p.Set(GetParam(), factor * p.Get(GetParam()));
  const BenchProfile profile = QuietBench();
  const Recording r = Record(p, profile);
  const SampledModel model = MakeSampledModel(p, kPeriodS, profile.delta_s);
  EXPECT_NEAR(
      FitSampled(model, 0, profile.friction.mc_nm, r.uc_v, r.um_v).fit_percent, 100.0, kPerfect);
}

TEST(ModelFit, FirstOrderModelMissesOnlyTheInductance) {
  const BenchProfile profile = paper::CircuitSimulation();
  const PlantParameters p = paper::Plant();
  const Recording r = Record(p, profile);
  const double fit =
      FitContinuous(MakeContinuous(p), r.uc_v, r.um_v, kPeriodS, profile.delta_s).fit_percent;
  EXPECT_GT(fit, 99.7);
  EXPECT_LT(fit, 100.0);
  PlantParameters without = p;
  without.la_henry = 1e-9;
  const Recording exact = Record(without, profile);
  EXPECT_NEAR(FitContinuous(MakeContinuous(p), exact.uc_v, exact.um_v, kPeriodS, profile.delta_s)
                  .fit_percent,
              100.0,
              5e-3);  // Eq. (4) also drops the products with C8 = 47 pF
}

TEST(ModelFit, IgnoringDeltaCostsFit) {
  const BenchProfile profile = paper::CircuitSimulation();
  const Recording r = Record(paper::Plant(), profile);
  const ContinuousCoefficients c = MakeContinuous(paper::Plant());
  EXPECT_LT(FitContinuous(c, r.uc_v, r.um_v, kPeriodS, 0.0).fit_percent, 97.0);
}

TEST(ModelFit, FrictionChannelMattersWhenR1IsLarge) {
  PlantParameters p = paper::Plant();
  p.series_ohm = 100.0;
  const BenchProfile profile = QuietBench();
  const Recording r = Record(p, profile);
  const ContinuousCoefficients c = MakeContinuous(p);
  const auto fit = [&](double mc_nm) {
    return FitFriction(c, mc_nm, r.uc_v, r.um_v, kPeriodS, profile.delta_s).fit_percent;
  };
  EXPECT_GT(fit(0.33e-3), 99.5);
  EXPECT_LT(fit(0.48e-3), 40.0);
  EXPECT_LT(fit(0.0), -100.0);
}

TEST(ModelFit, FrictionTurnsAroundWithTheMotor) {
  BenchProfile profile = QuietBench();
  profile.amplifier.quadrants = Quadrants::kFour;
  profile.friction.ms_nm = profile.friction.mc_nm;
  const PlantParameters p = paper::Plant();
  const double mc_nm = profile.friction.mc_nm;
  const Recording r = Record(p, profile, MakePrbs({.low_v = -1.0, .high_v = 2.0}, 500, kPeriodS));
  const SampledModel model = MakeSampledModel(p, kPeriodS, profile.delta_s);
  const std::vector<double> directions = FrictionDirections(model, r.uc_v, mc_nm);
  EXPECT_EQ(std::ranges::max(directions), 1.0);
  EXPECT_EQ(std::ranges::min(directions), -1.0);
  EXPECT_GT(FitSampled(model, 0, mc_nm, r.uc_v, r.um_v).fit_percent, 99.9);
  const auto eq3 = [&](std::span<const double> along) {
    return FitFriction(MakeContinuous(p), mc_nm, r.uc_v, r.um_v, kPeriodS, profile.delta_s, along)
        .fit_percent;
  };
  EXPECT_GT(eq3(directions), 99.0);
  EXPECT_LT(eq3({}), eq3(directions));
}

TEST(ModelFit, FrictionActsOneWayUnderAnInputOfOneSign) {
  const SampledModel model = MakeSampledModel(paper::Plant(), kPeriodS, 0.0095);
  EXPECT_TRUE(FrictionDirections(model, MakePrbs({}, 500, kPeriodS), 0.33e-3).empty());
  EXPECT_TRUE(FrictionDirections(model, {}, 0.33e-3).empty());
}

TEST(SampledModel, SteadyStateIsAFixedPoint) {
  const SampledModel model = MakeSampledModel(paper::Plant(), kPeriodS, 0.0095);
  const Eigen::Vector3d x = model.SteadyState(2.5, 0.33e-3);
  const Eigen::Vector3d next = model.phi * x + model.gamma_u * 2.5 + model.gamma_m * 0.33e-3;
  EXPECT_LT((next - x).norm(), 1e-10 * x.norm());
  EXPECT_NEAR(x(0), 6.0, 1e-9);  // C8 charged to the output voltage
}

}  // namespace
}  // namespace faultlab::core
