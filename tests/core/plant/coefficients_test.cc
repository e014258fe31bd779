#include "core/plant/coefficients.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/plant/sampled_model.h"
#include "core/signals/random.h"
#include "core/types/estimated_channel.h"
#include "hardware/bench/benches.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.01;
// Half a unit of the last printed digit.
constexpr double kPrinted4 = 0.5e-4;
constexpr double kRounding = 1e-12;

PlantParameters Faulty(Component component, double value) {
  PlantParameters parameters = paper::Plant();
  parameters.Set(component, value);
  return parameters;
}

TEST(Coefficients, NominalValuesAreThoseOfThePaper) {
  const ContinuousCoefficients c = MakeContinuous(paper::Plant());
  EXPECT_NEAR(c.b0, 2.3935, kPrinted4);
  EXPECT_NEAR(c.b1, 0.0382, kPrinted4);
  EXPECT_NEAR(c.a1, 0.01807, 0.5e-5);
  const DiscreteCoefficients d = Discretise(c, kPeriodS, 0.0);
  EXPECT_NEAR(d.b0d, 2.1146, kPrinted4);
  EXPECT_NEAR(d.b1d, -1.0975, kPrinted4);
  EXPECT_NEAR(d.a1d, -0.5751, kPrinted4);
}

TEST(Coefficients, GainOnlyFaultsLeaveThePoleAlone) {
  const ContinuousCoefficients nominal = MakeContinuous(paper::Plant());
  EXPECT_EQ(MakeContinuous(Faulty(paper::kR9, 33e3)).a1, nominal.a1);
  EXPECT_NEAR(MakeContinuous(Faulty(paper::kR12, 2e3)).a1, nominal.a1, 1e-6);  // C8 = 47 pF
  EXPECT_NEAR(MakeContinuous(Faulty(paper::kR9, 33e3)).b0, 1.559, 0.5e-3);     // erratum 2
}

TEST(Coefficients, DiscretisationIsTheSampledStepResponse) {
  // Closed form: y(t) = b0 (1 - e^-t/a1) + b1/a1 e^-t/a1 after a unit step at an edge.
  const ContinuousCoefficients c = MakeContinuous(Faulty(paper::kR1, 10.0));
  for (const double delta_s : {0.0, 0.0045, 0.0095}) {
    const DiscreteCoefficients d = Discretise(c, kPeriodS, delta_s);
    double y = d.b0d;
    for (int k = 0; k < 20; ++k) {
      const double t = k * kPeriodS + delta_s;
      const double decay = std::exp(-t / c.a1);
      EXPECT_NEAR(y, c.b0 * (1.0 - decay) + c.b1 / c.a1 * decay, kRounding) << k << " " << delta_s;
      y = d.b0d + d.b1d - d.a1d * y;
    }
  }
}

TEST(Coefficients, InverseUndoesDiscretisationForRandomPlantsAndDelays) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    PlantParameters parameters = paper::Plant();
    for (const Component component : paper::Parts()) {
      parameters.Set(component, parameters.Get(component) * std::exp(random.Uniform(-1.5, 1.5)));
    }
    const double delta_s = random.Uniform(0.0, kPeriodS);
    const ContinuousCoefficients c = MakeContinuous(parameters);
    const auto back = MakeContinuous(Discretise(c, kPeriodS, delta_s), kPeriodS, delta_s);
    ASSERT_TRUE(back.has_value());
    // The logarithm of a1d near 0 and the growth exp(delta/a1) amplify rounding.
    const double tolerance = 1e-14 * std::exp(2.0 * kPeriodS / c.a1) + 1e-10;
    EXPECT_NEAR(back->b0, c.b0, tolerance * c.b0);
    EXPECT_NEAR(back->b1, c.b1, tolerance * c.b1 * 10);
    EXPECT_NEAR(back->a1, c.a1, tolerance * c.a1);
  }
}

TEST(Coefficients, NoContinuousModelForAPoleOutsideTheUnitIntervalIsClaimed) {
  EXPECT_FALSE(MakeContinuous(DiscreteCoefficients{2.0, -1.0, -1.0}, kPeriodS, 0.0).has_value());
  EXPECT_FALSE(MakeContinuous(DiscreteCoefficients{2.0, -1.0, 0.2}, kPeriodS, 0.0).has_value());
  EXPECT_FALSE(
      MakeContinuous(DiscreteCoefficients{2.0, -1.0, std::nan("")}, kPeriodS, 0.0).has_value());
}

// Check values of the exact Jacobian at nominal, five digits, computed independently of this code.
constexpr double kCheck[3][8] = {
    {-6.4749e-3, -1.1968e-4, 1.9946e-4, 0.0, 1.756e-5, 0.0, -3.5249e3, 0.0},
    {-1.0339e-4, -1.9110e-6, 3.1850e-6, 2393.5, 5.0545e-3, 2.6727e4, -4.8307e2, 0.0},
    {2.1002e-3, 0.0, 4.7e-11, 1.3e4, 2.1002e-3, 1.2639e4, -2.2844e2, 0.0}};

TEST(CoefficientJacobian, HasTheKnownValuesAtNominal) {
  const CoefficientJacobian jacobian = ContinuousJacobian(paper::Plant(), paper::Parts());
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < paper::Bench().component_count(); ++column) {
      const double expected = kCheck[row][column];
      EXPECT_NEAR(jacobian(row, column), expected, 3e-4 * std::abs(expected))
          << row << " " << column;
    }
  }
}

/// One bench for each channel that can be estimated: um, ia, n.
class EachChannel : public testing::TestWithParam<const char*> {
 protected:
  const Bench& bench_ = *hardware::LoadBench(GetParam()).value();
};
INSTANTIATE_TEST_SUITE_P(Benches,
                         EachChannel,
                         testing::Values("paper", "servo-motor", "speed-motor"),
                         [](const auto& test) {
                           const Bench& bench = *hardware::LoadBench(test.param).value();
                           return std::string(InfoOf(bench.structure->estimated).name);
                         });

TEST_P(EachChannel, SettlesWhereTheExactModelDoes) {
  constexpr double kUc = 2.5;
  constexpr double kMc = 1e-4;
  const PlantParameters& plant = bench_.nominal;
  const SampledModel exact = MakeSampledModel(plant, kPeriodS, 0.5 * kPeriodS);
  const Eigen::Vector3d at_rest = exact.SteadyState(kUc, kMc);
  const int row = InfoOf(plant.structure->estimated).row;
  const double output = exact.c.row(row).dot(at_rest) + exact.d_u(row) * kUc + exact.d_m(row) * kMc;
  const ContinuousCoefficients c = MakeContinuous(plant);
  const double expected = ReadingPerOutput(plant) * output;
  EXPECT_NEAR(c.b0 * kUc - c.b02 * kMc, expected, 1e-6 * std::abs(expected));
}

TEST_P(EachChannel, JacobianEqualsCentralDifferencesAtRandomPlants) {
  Random random(11);
  constexpr double kStep = 1e-5;  // truncation 1e-10, rounding 1e-11 of the values
  const std::vector<Component> parts = bench_.components();
  for (int i = 0; i < 50; ++i) {
    PlantParameters parameters = bench_.nominal;
    for (const Component component : parts) {
      parameters.Set(component, parameters.Get(component) * std::exp(random.Uniform(-1.0, 1.0)));
      if (component.info().symbol != "C8") continue;
      // so that it has an effect
      parameters.Set(component, 1e-6 * std::exp(random.Uniform(-1.0, 1.0)));
    }
    const double delta_s = random.Uniform(0.0, kPeriodS);
    const CoefficientJacobian continuous = ContinuousJacobian(parameters, parts);
    const CoefficientJacobian discrete = DiscreteJacobian(parameters, parts, kPeriodS, delta_s);
    for (std::size_t place = 0; place < parts.size(); ++place) {
      const Component component = parts[place];
      const double value = parameters.Get(component);
      PlantParameters up = parameters;
      PlantParameters down = parameters;
      up.Set(component, value * (1.0 + kStep));
      down.Set(component, value * (1.0 - kStep));
      const ContinuousCoefficients cu = MakeContinuous(up);
      const ContinuousCoefficients cd = MakeContinuous(down);
      const DiscreteCoefficients du = Discretise(cu, kPeriodS, delta_s);
      const DiscreteCoefficients dd = Discretise(cd, kPeriodS, delta_s);
      const double twice = 2.0 * kStep * value;
      const double expected[6] = {cu.b0 - cd.b0,
                                  cu.b1 - cd.b1,
                                  cu.a1 - cd.a1,
                                  du.b0d - dd.b0d,
                                  du.b1d - dd.b1d,
                                  du.a1d - dd.a1d};
      const double at_once = std::max(cu.b0, cu.b1 / cu.a1);
      const double scale[6] = {cu.b0, cu.a1 * at_once, cu.a1, at_once, at_once, 1.0};
      for (int row = 0; row < 6; ++row) {
        const double found = row < 3 ? continuous(row, static_cast<Eigen::Index>(place))
                                     : discrete(row - 3, static_cast<Eigen::Index>(place));
        EXPECT_NEAR(found * value, expected[row] / twice * value, 1e-8 * scale[row])
            << Name(component) << " " << row;
      }
    }
  }
}

}  // namespace
}  // namespace faultlab::core
