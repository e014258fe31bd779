#include "core/filter/map_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

// log(Ra) and log(J) of a bench whose Ra is 20 % and whose J is 10 % above the data sheet.
class MapFitOfTwo : public testing::Test {
 protected:
  MapFitOfTwo() {
    PlantParameters rig = paper::Plant();
    rig.ra_ohm *= 1.2;
    rig.j_kg_m2 *= 1.1;
    stretch_ = MakeObservations(
        BenchRecord({}, 71, 6.0, rig), paper::Bench().readings(), Channels::kAll, 0.01, 10.0);
    models_.stretch = stretch_;
    models_.model_at = [](const Eigen::VectorXd& q, std::size_t) {
      RigParameters at = paper::Rig();
      at.mc_nm = 0.33e-3;
      at.plant.ra_ohm *= std::exp(q(0));
      at.plant.j_kg_m2 *= std::exp(q(1));
      NoiseLevel noise = paper::Noise();
      noise.w_rad_s = 0.5 * paper::kRadPerSecondOfRpm;
      return MakePredictionModel(at, noise, 0.01);
    };
    prior_.mean = Eigen::VectorXd::Zero(2);
    prior_.information = Eigen::MatrixXd::Identity(2, 2);
  }

  double CostAt(const Eigen::VectorXd& q) const {
    const Eigen::VectorXd off = q - prior_.mean;
    return RunInnovations(models_.model_at(q, 0), stretch_).cost() +
           off.dot(prior_.information * off);
  }

  std::vector<Observation> stretch_;
  StretchModels models_;
  GaussianPrior prior_;
};

TEST_F(MapFitOfTwo, FindsTheLowestCostAndSaysHowSharpItIs) {
  const MapFit fit = FitMap(models_, prior_, prior_.mean);
  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(fit.point(0), std::log(1.2), 0.01);
  EXPECT_NEAR(fit.point(1), std::log(1.1), 0.01);
  EXPECT_NEAR(fit.cost(), CostAt(fit.point), 1e-9 * std::abs(fit.cost()));
  // Moving one coordinate by `step` and holding the other raises the cost by step^2 times the
  // curvature along it.
  for (Eigen::Index i = 0; i < 2; ++i) {
    const double step = 3.0 * std::sqrt(fit.covariance(i, i));
    const double rise = step * step * (fit.information(i, i) + prior_.information(i, i));
    for (double side : {-1.0, 1.0}) {
      Eigen::VectorXd q = fit.point;
      q(i) += side * step;
      EXPECT_NEAR(CostAt(q) - fit.cost(), rise, 0.1 * rise) << i << " " << side;
    }
  }
}

TEST_F(MapFitOfTwo, GivesUpOnlyWhatCannotComeBelowTheCost) {
  const MapFit whole = FitMap(models_, prior_, prior_.mean);
  MapFitOptions options;
  options.give_up_above = whole.cost() + 1.0;
  const MapFit kept = FitMap(models_, prior_, prior_.mean, options);
  EXPECT_TRUE(kept.converged);
  EXPECT_EQ(kept.cost(), whole.cost());
  options.give_up_above = whole.cost() - 100.0 * std::abs(CostAt(prior_.mean));
  const MapFit given_up = FitMap(models_, prior_, prior_.mean, options);
  EXPECT_FALSE(given_up.converged);
  EXPECT_EQ(given_up.iterations, 0);
  EXPECT_EQ(given_up.point, prior_.mean);
}

}  // namespace
}  // namespace faultlab::core
