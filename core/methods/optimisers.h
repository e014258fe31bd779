#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/signals/random.h"

namespace faultlab::core {

/// A cost to be minimised over the box [low, high], any dimension.
using BoxCost = std::function<double(const Eigen::VectorXd&)>;

struct Box {
  Eigen::VectorXd low;
  Eigen::VectorXd high;
};

struct Optimum {
  Eigen::VectorXd point;
  double cost = 0.0;
};

/// Each evaluates the cost `population` x `rounds` times. The same seed gives the same optimum.
struct SearchEffort {
  int population = 20;
  int rounds = 20;
};

/// Real-coded genetic algorithm: tournaments of two, blend crossover (alpha 0.3), Gaussian mutation
/// whose width shrinks with the rounds, the best survives.
/// Source: L. J. Eshelman, J. D. Schaffer, Foundations of Genetic Algorithms 2 (1993).
Optimum GeneticAlgorithm(const Box& box, const BoxCost& cost, SearchEffort effort, Random& random);

/// Particle swarm: v <- w v + c1 r1 (own best - x) + c2 r2 (best - x), x <- x + v,
/// w = 0.729, c1 = c2 = 1.494.
/// Source: J. Kennedy, R. Eberhart, ICNN (1995); M. Clerc, J. Kennedy, IEEE Trans. Evol. Comput. 6
/// (2002).
Optimum ParticleSwarm(const Box& box, const BoxCost& cost, SearchEffort effort, Random& random);

/// Whale optimisation: encircling x <- best - A |C best - x|, search around a random whale while
/// |A| > 1, spiral x <- |best - x| e^(l) cos(2 pi l) + best; a falls from 2 to 0.
/// Source: S. Mirjalili, A. Lewis, Adv. Eng. Software 95 (2016).
Optimum WhaleOptimisation(const Box& box, const BoxCost& cost, SearchEffort effort, Random& random);

}  // namespace faultlab::core
