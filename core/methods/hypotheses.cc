#include "core/methods/hypotheses.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/isolation/fit_context.h"
#include "core/isolation/profile_cost.h"
#include "core/numerics/golden_section.h"

namespace faultlab::core {

void FinishFinding(double same, bool sized, MethodFinding& finding) {
  std::stable_sort(
      finding.candidates.begin(),
      finding.candidates.end(),
      [](const MethodCandidate& a, const MethodCandidate& b) { return a.cost < b.cost; });
  finding.named = 0;
  if (finding.candidates.empty() || !std::isfinite(finding.candidates.front().cost)) {
    finding.candidates.clear();
    finding.isolation = Answer::kNotYet;
    finding.identification = sized ? Answer::kNotYet : Answer::kCannot;
    return;
  }
  const double limit = finding.candidates.front().cost + same;
  while (finding.named < finding.candidates.size() &&
         finding.candidates[finding.named].cost <= limit) {
    ++finding.named;
  }
  finding.isolation = Answer::kGiven;
  finding.identification = sized ? Answer::kGiven : Answer::kCannot;
}

PredictionModel ModelOf(const MethodTask& task, Component component, double log_value) {
  const RigParameters rig =
      WithComponent(ParametersOf(task.calibration), component, std::exp(log_value));
  return MakePredictionModel(rig, NoiseOf(task.calibration), task.period_s);
}

PredictionModel HealthyModel(const MethodTask& task) {
  return MakePredictionModel(
      ParametersOf(task.calibration), NoiseOf(task.calibration), task.period_s);
}

PredictionModel WatchedModel(const MethodTask& task) {
  return MakePredictionModel(
      ParametersOf(task.calibration), DetectionNoiseOf(task.calibration), task.period_s);
}

double LogStart(const MethodTask& task, Component component) {
  const double nominal = task.calibration.nominal.Get(component);
  // A share of the smallest value that shows: the search starts where the cost begins to change.
  constexpr double kBelowVisible = 0.03;
  return std::log(std::max(nominal, kBelowVisible * component.info().least_visible));
}

double LogVisible(const MethodTask& task, Component component) {
  const double least = component.info().least_visible;
  const double start = LogStart(task, component);
  return least > 0.0 ? std::max(start, std::log(least)) : start;
}

namespace {
Eigen::VectorXd OutputOf(const MethodTask& task, const PredictionModel& model) {
  Eigen::VectorXd y(static_cast<Eigen::Index>(task.healthy.size()));
  Eigen::Vector4d x = TurningState(model, task.healthy.front().u_prev);
  Eigen::Index k = 0;
  for (const Observation& o : task.healthy) {
    const Eigen::Vector4d moved = Step(model, x, model.Limited(o.u_prev), model.Limited(o.u));
    x = moved;
    y(k++) = model.c.row(task.channel()).dot(x) + model.d(task.channel()) * model.Limited(o.u);
  }
  return y;
}
}  // namespace

std::vector<Component> DistinctComponents(const MethodTask& task) {
  std::vector<Component> distinct;
  std::vector<Eigen::VectorXd> effects;
  if (task.healthy.empty()) return distinct;
  for (const Component component : task.bench->components()) {
    constexpr double kStep = 1e-3;
    const double at = LogVisible(task, component);
    Eigen::VectorXd effect = OutputOf(task, ModelOf(task, component, at + kStep)) -
                             OutputOf(task, ModelOf(task, component, at));
    const double size = effect.norm();
    if (!(size > 0.0)) continue;
    effect /= size;
    constexpr double kSame = 1e-5;
    const bool seen = std::any_of(effects.begin(), effects.end(), [&](const auto& other) {
      return 1.0 - std::abs(effect.dot(other)) < kSame;
    });
    if (seen) continue;
    effects.push_back(effect);
    distinct.push_back(component);
  }
  return distinct;
}

MethodCandidate SearchValue(Component component,
                            const std::vector<double>& scan,
                            const std::function<double(Component, double)>& cost) {
  const ValueRange range = RangeOf(component);
  int best = 0;
  for (int i = 1; i < range.points; ++i) {
    if (!(scan[static_cast<std::size_t>(i)] >= scan[static_cast<std::size_t>(best)])) best = i;
  }
  constexpr int kSteps = 24;  // a hundred-thousandth of two steps of the scan
  const double low = range.LogAt(std::max(0, best - 1));
  const double high = range.LogAt(std::min(range.points - 1, best + 1));
  const GoldenSection found = SearchGoldenSection(
      low, high, kSteps, [&](double log_value) { return cost(component, log_value); });
  return {component, std::exp(found.best()), found.best_cost()};
}

MethodCandidate SearchValue(Component component,
                            const std::function<double(Component, double)>& cost) {
  const ValueRange range = RangeOf(component);
  std::vector<double> scan;
  for (int i = 0; i < range.points; ++i) scan.push_back(cost(component, range.LogAt(i)));
  return SearchValue(component, scan, cost);
}

}  // namespace faultlab::core
