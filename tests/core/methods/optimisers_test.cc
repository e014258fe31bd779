#include "core/methods/optimisers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace faultlab::core {
namespace {

using Optimiser = Optimum (*)(const Box&, const BoxCost&, SearchEffort, Random&);

class Optimisers : public testing::TestWithParam<Optimiser> {};

// A bowl with ripples: a descent from most points ends in a ripple.
double Rippled(const Eigen::VectorXd& x) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double off = x(i) - 1.3;
    sum += off * off + 0.5 * (1.0 - std::cos(6.0 * off));
  }
  return sum;
}

TEST_P(Optimisers, FindTheLowestOfManyMinima) {
  for (const Eigen::Index dimension : {1, 2}) {
    const Box box = {Eigen::VectorXd::Constant(dimension, -10.0),
                     Eigen::VectorXd::Constant(dimension, 10.0)};
    Random random(3);
    const Optimum found = GetParam()(box, &Rippled, {30, 60}, random);
    for (Eigen::Index i = 0; i < dimension; ++i) EXPECT_NEAR(found.point(i), 1.3, 0.05);
    EXPECT_DOUBLE_EQ(found.cost, Rippled(found.point));
  }
}

TEST_P(Optimisers, StayInsideAndSpendWhatIsAllowed) {
  const Box box = {Eigen::VectorXd::Constant(1, 2.0), Eigen::VectorXd::Constant(1, 3.0)};
  int evaluations = 0;
  Random random(4);
  const Optimum found = GetParam()(
      box,
      [&](const Eigen::VectorXd& x) {
        ++evaluations;
        EXPECT_GE(x(0), 2.0);
        EXPECT_LE(x(0), 3.0);
        return x(0);
      },
      {10, 12},
      random);
  EXPECT_NEAR(found.point(0), 2.0, 0.02);
  EXPECT_LE(evaluations, 120);
  EXPECT_GE(evaluations, 108);
}

TEST_P(Optimisers, GiveTheSameForTheSameSeed) {
  const Box box = {Eigen::VectorXd::Constant(1, -10.0), Eigen::VectorXd::Constant(1, 10.0)};
  Random first(5);
  Random second(5);
  Random third(6);
  const double cost = GetParam()(box, &Rippled, {10, 5}, first).cost;
  EXPECT_EQ(cost, GetParam()(box, &Rippled, {10, 5}, second).cost);
  EXPECT_NE(cost, GetParam()(box, &Rippled, {10, 5}, third).cost);
}

INSTANTIATE_TEST_SUITE_P(All,
                         Optimisers,
                         testing::Values(&GeneticAlgorithm, &ParticleSwarm, &WhaleOptimisation));

}  // namespace
}  // namespace faultlab::core
