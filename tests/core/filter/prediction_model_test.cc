#include "core/filter/prediction_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/numerics/rest_passage.h"
#include "core/plant/sampled_model.h"
#include "core/signals/prbs.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

TEST(PredictionModel, AgreesWithThePlantsOwnSampledModel) {
  RigParameters rig = paper::Rig();
  rig.plant.Set(paper::kC8, 2.2e-6);
  rig.plant.series_ohm = 10.0;
  rig.mc_nm = 0.33e-3;
  const PredictionModel mine = MakePredictionModel(rig, paper::Noise(), 0.01);
  const SampledModel other = MakeSampledModel(rig.plant, 0.01, rig.delta_s);
  PrbsSpec spec;
  const std::vector<double> uc = MakePrbs(spec, 400, 0.01);
  Eigen::Vector3d x_other = Eigen::Vector3d::Zero();
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  double worst = 0.0;
  for (std::size_t k = 0; k < uc.size(); ++k) {
    const Eigen::Vector3d y_other = other.c * x_other + other.d_u * uc[k] + other.d_m * rig.mc_nm;
    const Eigen::Vector3d next_other =
        other.phi * x_other + other.gamma_u * uc[k] + other.gamma_m * rig.mc_nm;
    x_other = next_other;
    const Eigen::Vector4d next = mine.phi * x + mine.g_prev * uc[k == 0 ? 0 : k - 1] +
                                 mine.g * uc[k] + mine.g_torque * rig.mc_nm;
    x = next;
    const Eigen::Vector3d y = mine.c * x + mine.d * uc[k];
    // The first samples differ by the start: one model starts at the edge, the other at the
    // reading.
    if (k > 100) worst = std::max(worst, (y - y_other).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(PredictionModel, FrictionActsOneWayUntilTheMotorPassesThroughRest) {
  EXPECT_EQ(MeanDirection(100.0, 90.0, 5.0, 1.0), 1.0);
  EXPECT_EQ(MeanDirection(-100.0, -90.0, 5.0, 1.0), -1.0);
  EXPECT_EQ(MeanDirection(0.0, 8.0, 5.0, 1.0), 1.0);
  // From 6 to -14 in a period, with friction 4 of it: rest after 6/20 of the period.
  EXPECT_DOUBLE_EQ(MeanDirection(6.0, -10.0, 4.0, 1.0), 0.3 - 0.7);
  EXPECT_DOUBLE_EQ(MeanDirection(-6.0, 10.0, 4.0, 1.0), 0.7 - 0.3);
  EXPECT_EQ(MeanDirection(6.0, -10.0, 0.0, 1.0) < 0.0, true)
      << "without friction its way is still known";
}

TEST(PredictionModel, APassageThroughRestIsNoneWhereTheMotorTurnsOneWayOrStands) {
  const auto passage = [](double before, double free, double held) {
    return PassageShare(before, free, held, 1.0, MeanDirection(before, free, held, 1.0));
  };
  EXPECT_EQ(passage(100.0, 90.0, 5.0), 0.0);
  EXPECT_EQ(passage(3.0, 1.0, 8.0), 0.0);
  EXPECT_NEAR(passage(10.0, -10.0, 0.1), 1.0, 0.01);
  // Continuous where a passage begins, so that a fit can follow it.
  EXPECT_NEAR(passage(10.0, 5.0 - 1e-9, 5.0), 0.0, 1e-6);
}

TEST(PredictionModel, FrictionBringsTheMotorToRestAndHoldsItThere) {
  for (const double before : {0.0, 3.0, -3.0}) {
    for (const double drive : {-2.0, 0.0, 2.0}) {
      const double free = before + drive;
      EXPECT_NEAR(free - 8.0 * MeanDirection(before, free, 8.0, 1.0), 0.0, 1e-12)
          << before << drive;
    }
  }
}

}  // namespace
}  // namespace faultlab::core
