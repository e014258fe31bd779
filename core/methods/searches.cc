// Optimisation of the simulated output (paper section 1, [41, 42]): GA, PSO and WOA search the
// value of one component at a time,
//   cost(c, log value) = min over the initial state and a constant torque of sum (y - yhat)^2 / s^2
// yhat simulated by the exact sampled model over the samples since the alarm, not predicted one
// step ahead. The optimisers are in optimisers.h. One population for each component: over all
// values at once the cost has a valley of equal models, and no population found the truth.
// Detection: the sum of squares of the simulated output of the healthy rig over a block of 1 s,
// which changes only at the end of a block. Tuning: evaluations of the cost for a component.
#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "core/isolation/profile_cost.h"
#include "core/methods/hypotheses.h"
#include "core/methods/method_list.h"
#include "core/methods/optimisers.h"

namespace faultlab::core {
namespace {

using Optimiser = Optimum (*)(const Box&, const BoxCost&, SearchEffort, Random&);

// Sum of squares of the simulated output's error, with the state of amplifier, motor and friction
// at the start, (z, w, d), by least squares.
double SimulatedCost(const MethodTask& task,
                     const PredictionModel& model,
                     const std::vector<Observation>& stretch) {
  const int row = task.channel();
  constexpr int kFree = 3;
  const Eigen::RowVector4d c = model.c.row(row);
  Eigen::Vector4d x = TurningState(model, stretch.front().u_prev);
  Eigen::Matrix<double, 4, kFree> free = Eigen::Matrix<double, 4, kFree>::Zero();
  free(0, 0) = 1.0;   // V
  free(2, 1) = 10.0;  // rad/s
  free(3, 2) = std::sqrt(model.torque_variance) + 1e-5;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d phi = model.phi;
  phi(3, 3) = 1.0;  // a constant torque, for blocks as short as its correlation time
  for (const Observation& o : stretch) {
    const double u = model.Limited(o.u);
    const Eigen::Vector4d moved = Step(model, x, model.Limited(o.u_prev), u);
    x = moved;
    const Eigen::Matrix<double, 4, kFree> along = phi * free;
    free = along;
    if (!task.Has(o)) continue;
    Eigen::Vector4d entry;
    entry << (c * free).transpose(), task.Reading(o) - c.dot(x) - model.d(row) * u;
    moments.noalias() += entry * entry.transpose();
  }
  const Eigen::Matrix3d ridge = moments.topLeftCorner<3, 3>() + 1e-9 * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d cross = moments.topRightCorner<3, 1>();
  const double variance = task.noise() * task.noise();
  const double cost = (moments(3, 3) - cross.dot(ridge.ldlt().solve(cross))) / variance;
  return std::isfinite(cost) ? std::max(0.0, cost) : 1e18;
}

class OutputSearch : public Method {
 public:
  OutputSearch(const MethodTask& task, Optimiser optimiser)
      : task_(task),
        optimiser_(optimiser),
        healthy_(HealthyModel(task)),
        block_(std::max<std::size_t>(50,
                                     static_cast<std::size_t>(std::lround(1.0 / task.period_s)))) {}

  void Push(const Sample&, const Observation& o) override {
    if (o.restart) stretch_.clear();
    if (stretch_.size() < kStretchMax) stretch_.push_back(o);
    if (alarmed_ || stretch_.size() < block_) return;
    statistic_ = SimulatedCost(task_, healthy_, stretch_) / static_cast<double>(block_);
    stretch_.clear();
  }
  double statistic() const override { return statistic_; }
  void OnAlarm() override {
    alarmed_ = true;
    stretch_.clear();
  }
  MethodFinding Diagnose() override {
    MethodFinding finding;
    if (stretch_.size() < kFewest) return {Answer::kNotYet, Answer::kNotYet, {}, 0};
    Random random(task_.seed);
    constexpr int kPopulation = 20;
    const SearchEffort effort = {kPopulation, static_cast<int>(task_.tuning) / kPopulation};
    for (const Component component : task_.bench->components()) {
      const ValueRange range = RangeOf(component);
      const Box box = {Eigen::VectorXd::Constant(1, std::log(range.low)),
                       Eigen::VectorXd::Constant(1, std::log(range.high))};
      const Optimum found = optimiser_(
          box,
          [&](const Eigen::VectorXd& at) {
            return SimulatedCost(task_, ModelOf(task_, component, at(0)), stretch_);
          },
          effort,
          random);
      finding.candidates.push_back({component, std::exp(found.point(0)), found.cost});
    }
    FinishFinding(0.0, true, finding);
    return finding;
  }
  std::size_t bytes() const override {
    return sizeof *this + stretch_.capacity() * sizeof(Observation);
  }

 private:
  static constexpr std::size_t kStretchMax = 600;
  static constexpr std::size_t kFewest = 20;

  MethodTask task_;
  Optimiser optimiser_;
  PredictionModel healthy_;
  std::size_t block_;
  std::vector<Observation> stretch_;
  double statistic_ = 0.0;
  bool alarmed_ = false;
};

}  // namespace

std::unique_ptr<Method> MakeGeneticSearch(const MethodTask& task) {
  return std::make_unique<OutputSearch>(task, &GeneticAlgorithm);
}
std::unique_ptr<Method> MakeParticleSearch(const MethodTask& task) {
  return std::make_unique<OutputSearch>(task, &ParticleSwarm);
}
std::unique_ptr<Method> MakeWhaleSearch(const MethodTask& task) {
  return std::make_unique<OutputSearch>(task, &WhaleOptimisation);
}

}  // namespace faultlab::core
