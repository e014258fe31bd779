#include "core/methods/optimisers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace faultlab::core {
namespace {

Eigen::VectorXd Inside(const Box& box, const Eigen::VectorXd& point) {
  return point.cwiseMax(box.low).cwiseMin(box.high);
}

Eigen::VectorXd Draw(const Box& box, Random& random) {
  Eigen::VectorXd point(box.low.size());
  for (Eigen::Index i = 0; i < point.size(); ++i)
    point(i) = random.Uniform(box.low(i), box.high(i));
  return point;
}

// The first generation: one point in each of `population` slices of every axis (Latin hypercube),
// so that a small population misses no region.
std::vector<Optimum> Population(const Box& box,
                                const BoxCost& cost,
                                SearchEffort effort,
                                Random& random) {
  const auto n = static_cast<std::size_t>(effort.population);
  std::vector<Optimum> all(n, {Draw(box, random), 0.0});
  for (Eigen::Index axis = 0; axis < box.low.size(); ++axis) {
    std::vector<std::size_t> slice(n);
    for (std::size_t i = 0; i < n; ++i) slice[i] = i;
    for (std::size_t i = n; i > 1; --i) std::swap(slice[i - 1], slice[random.Below(i)]);
    for (std::size_t i = 0; i < n; ++i) {
      const double share =
          (static_cast<double>(slice[i]) + random.Uniform()) / static_cast<double>(n);
      all[i].point(axis) = box.low(axis) + share * (box.high(axis) - box.low(axis));
    }
  }
  for (Optimum& each : all) each.cost = cost(each.point);
  return all;
}

Optimum BestOf(const std::vector<Optimum>& all) {
  return *std::min_element(
      all.begin(), all.end(), [](const Optimum& a, const Optimum& b) { return a.cost < b.cost; });
}

}  // namespace

Optimum GeneticAlgorithm(const Box& box, const BoxCost& cost, SearchEffort effort, Random& random) {
  std::vector<Optimum> parents = Population(box, cost, effort, random);
  const auto tournament = [&]() -> const Optimum& {
    const Optimum& a = parents[random.Below(parents.size())];
    const Optimum& b = parents[random.Below(parents.size())];
    return a.cost < b.cost ? a : b;
  };
  constexpr double kBlend = 0.3;
  constexpr double kMutated = 0.2;  // share of the coordinates
  for (int round = 1; round < effort.rounds; ++round) {
    const double width = 0.2 * (1.0 - static_cast<double>(round) / effort.rounds);
    std::vector<Optimum> children = {BestOf(parents)};
    while (children.size() < parents.size()) {
      const Optimum& a = tournament();
      const Optimum& b = tournament();
      Eigen::VectorXd child(box.low.size());
      for (Eigen::Index i = 0; i < child.size(); ++i) {
        const double share = random.Uniform(-kBlend, 1.0 + kBlend);
        child(i) = a.point(i) + share * (b.point(i) - a.point(i));
        if (random.Uniform() < kMutated) {
          child(i) += width * (box.high(i) - box.low(i)) * random.Normal();
        }
      }
      child = Inside(box, child);
      children.push_back({child, cost(child)});
    }
    parents = std::move(children);
  }
  return BestOf(parents);
}

Optimum ParticleSwarm(const Box& box, const BoxCost& cost, SearchEffort effort, Random& random) {
  constexpr double kInertia = 0.729;
  constexpr double kPull = 1.494;
  std::vector<Optimum> own = Population(box, cost, effort, random);
  std::vector<Eigen::VectorXd> x;
  for (const Optimum& each : own) x.push_back(each.point);
  std::vector<Eigen::VectorXd> v(own.size(), Eigen::VectorXd::Zero(box.low.size()));
  Optimum best = BestOf(own);
  for (int round = 1; round < effort.rounds; ++round) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (Eigen::Index k = 0; k < x[i].size(); ++k) {
        v[i](k) = kInertia * v[i](k) + kPull * random.Uniform() * (own[i].point(k) - x[i](k)) +
                  kPull * random.Uniform() * (best.point(k) - x[i](k));
      }
      const Eigen::VectorXd moved = Inside(box, x[i] + v[i]);
      x[i] = moved;
      const double now = cost(x[i]);
      if (now < own[i].cost) own[i] = {x[i], now};
      if (now < best.cost) best = {x[i], now};
    }
  }
  return best;
}

Optimum WhaleOptimisation(const Box& box,
                          const BoxCost& cost,
                          SearchEffort effort,
                          Random& random) {
  std::vector<Optimum> whales = Population(box, cost, effort, random);
  Optimum best = BestOf(whales);
  for (int round = 1; round < effort.rounds; ++round) {
    const double a = 2.0 - 2.0 * static_cast<double>(round) / effort.rounds;
    for (Optimum& whale : whales) {
      const double shrink = 2.0 * a * random.Uniform() - a;
      const double weight = 2.0 * random.Uniform();
      const bool spiral = random.Uniform() < 0.5;
      const Eigen::VectorXd& leader = !spiral && std::abs(shrink) >= 1.0
                                          ? whales[random.Below(whales.size())].point
                                          : best.point;
      Eigen::VectorXd next;
      if (spiral) {
        const double l = random.Uniform(-1.0, 1.0);
        next = (best.point - whale.point).cwiseAbs() *
                   (std::exp(l) * std::cos(2.0 * std::numbers::pi * l)) +
               best.point;
      } else {
        next = leader - shrink * (weight * leader - whale.point).cwiseAbs();
      }
      whale.point = Inside(box, next);
      whale.cost = cost(whale.point);
      if (whale.cost < best.cost) best = whale;
    }
  }
  return best;
}

}  // namespace faultlab::core
