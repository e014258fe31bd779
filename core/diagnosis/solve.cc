#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "core/diagnosis/hypothesis.h"
#include "core/diagnosis/isolation.h"
#include "core/diagnosis/verdict_text.h"

namespace faultlab::core {
namespace {

// Gain in -2 log p over "nothing changed" that a fault must bring, scan of seven included.
constexpr double kFaultGain = 20.0;
// Hypotheses this close to the best are not excluded: three standard deviations.
constexpr double kNotExcludedCost = 9.0;
// Per-sample squared distance of whitened predictions below which an hour of data would not tell
// two hypotheses apart (3.6e5 samples x 2e-5 = 7).
constexpr double kSamePrediction = 2e-5;
// What the freed coordinates may gain when the hypothesis is right: chi-square with about seven
// degrees of freedom (99.9999 % at 41), and what the model leaves out.
constexpr double kFreeGainMax = 45.0;
// A second change below this share is the model's error, not a fault.
constexpr double kFreeShareMin = 0.03;
constexpr double kScoreMax = 1.6;
constexpr int kCountForUnknown = 60;

GaussianPrior PriorOf(const Calibration& calibration) {
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(kCoordinateCount);
  LAB_CHECK(calibration.covariance.size() ==
                static_cast<std::size_t>(kCoordinateCount * kCoordinateCount),
            calibration.covariance.size());
  const Eigen::Map<const Eigen::Matrix<double, kCoordinateCount, kCoordinateCount>> covariance(
      calibration.covariance.data());
  const Eigen::MatrixXd regular =
      covariance + 1e-12 * Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount);
  prior.information =
      regular.ldlt().solve(Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount));
  return prior;
}

bool MayChange(const IsolationOptions& options, Component component) {
  return IsRelaySwitched(component) || options.motor_faults;
}

Candidate ToCandidate(const HypothesisFit& fit, double best_score) {
  Candidate candidate;
  candidate.component = fit.component;
  candidate.value = fit.value;
  candidate.bound = fit.bound;
  candidate.sigma =
      fit.bound != 0 ? std::numeric_limits<double>::quiet_NaN() : fit.value * fit.log_sigma;
  candidate.score = fit.chi2 / std::max(1, fit.count);
  candidate.margin = candidate.score - best_score;
  return candidate;
}

std::vector<HypothesisFit> FitRelayValues(const FitContext& context, Component component) {
  std::vector<HypothesisFit> fits;
  const auto& values = RelayValues(component);
  for (std::size_t i = 1; i < values.size(); ++i) {
    fits.push_back(FitComponentAt(context, component, values[i]));
  }
  return fits;
}

IsolationResult SolveCalibration(const IsolationTask& task) {
  IsolationResult result;
  result.kind = IsolationTask::Kind::kCalibrate;
  result.id = task.id;
  Result<Calibration> calibration = Calibrate(task.samples, task.calibration_options);
  if (calibration.ok()) {
    result.calibration = std::make_shared<const Calibration>(std::move(calibration.value()));
  } else {
    result.refusal = calibration.error();
  }
  return result;
}

// What moved when everything was set free, for the sentence of an unknown fault.
std::string LargestMoves(const FreeFit& free) {
  constexpr std::array<const char*, kCoordinateCount> kLabels = {
      "gain", "R1", "Ra", "J", "B", "Ke", "friction torque", "delta"};
  std::string text;
  for (int i = 0; i < kCoordinateCount; ++i) {
    if (std::abs(free.point(i)) < 5.0 * free.sigma(i)) continue;
    if (std::abs(free.point(i)) < kFreeShareMin) continue;
    if (!text.empty()) text += ", ";
    text += kLabels[static_cast<std::size_t>(i)];
  }
  return text;
}

}  // namespace

IsolationResult Solve(const IsolationTask& task) {
  if (task.kind == IsolationTask::Kind::kCalibrate) return SolveCalibration(task);
  LAB_CHECK(task.calibration != nullptr);
  const Calibration& calibration = *task.calibration;
  IsolationResult result;
  result.id = task.id;
  Verdict& verdict = result.verdict;
  verdict.detected_at_s = task.alarm_t_s;
  verdict.detector = task.detector;
  verdict.settled = task.settled;

  const std::vector<Observation> observations = MakeObservations(
      task.samples, task.options.channels, task.options.period_s, task.options.um_rail_v);
  FitContext context;
  context.rig = ParametersOf(calibration);
  context.noise = NoiseOf(calibration);
  context.calibration = PriorOf(calibration);
  context.period_s = task.options.period_s;
  context.stretch = std::span<const Observation>(observations)
                        .subspan(std::min(task.fit_from, observations.size()));

  const HypothesisFit nothing = FitNothing(context);
  std::vector<HypothesisFit> fits;
  for (Component component : kAllComponents) {
    if (MayChange(task.options, component)) fits.push_back(FitComponent(context, component));
  }
  const auto by_cost = [](const HypothesisFit& a, const HypothesisFit& b) {
    return a.cost < b.cost;
  };
  std::sort(fits.begin(), fits.end(), by_cost);

  bool off_list = false;
  if (task.options.values == ValuePrior::kTable2) {
    std::vector<HypothesisFit> listed;
    for (const HypothesisFit& fit : fits) {
      if (!IsRelaySwitched(fit.component)) {
        listed.push_back(fit);
        continue;
      }
      if (fit.cost > fits.front().cost + 1e3) continue;
      std::vector<HypothesisFit> at = FitRelayValues(context, fit.component);
      HypothesisFit best = *std::min_element(at.begin(), at.end(), by_cost);
      best.log_sigma = 0.0;
      listed.push_back(best);
    }
    std::sort(listed.begin(), listed.end(), by_cost);
    off_list = listed.empty() || listed.front().cost > fits.front().cost + kFreeGainMax;
    if (!off_list) {
      for (const HypothesisFit& fit : fits) {
        const bool there = std::any_of(listed.begin(), listed.end(), [&](const HypothesisFit& l) {
          return l.component == fit.component;
        });
        if (!there) listed.push_back(fit);
      }
      fits = std::move(listed);
    }
  }

  const HypothesisFit& best = fits.front();
  const double score = best.chi2 / std::max(1, best.count);
  result.explained = score;
  if (nothing.cost - best.cost < kFaultGain) {
    result.returned_to_nominal = true;
    verdict.kind = VerdictKind::kNominal;
    verdict.reason =
        "nothing has changed that lasts: the record after the alarm fits the nominal rig";
    return result;
  }
  for (const HypothesisFit& fit : fits) {
    if (!fit.exists) continue;
    verdict.candidates.push_back(ToCandidate(fit, score));
    const bool close = fit.cost - best.cost < kNotExcludedCost;
    const bool same = fit.cost - best.cost < 1e3 && task.options.values == ValuePrior::kNone &&
                      PredictionDistance(context, best, fit) < kSamePrediction;
    if (&fit == &best || close || same) verdict.group.push_back(fit.component);
  }
  result.present = {verdict.candidates.front()};
  verdict.kind = VerdictKind::kFault;
  verdict.reason = FaultSentence(verdict);
  if (off_list) verdict.reason += "; no relay position has this value";

  if (best.count >= kCountForUnknown) {
    const FreeFit free = FitFree(context, best);
    const std::string moves = LargestMoves(free);
    const bool structural = best.cost - free.cost > kFreeGainMax && !moves.empty();
    if (structural || score > kScoreMax) {
      verdict.kind = VerdictKind::kUnknownFault;
      verdict.group.clear();
      verdict.reason = "no single component explains the record";
      if (!moves.empty())
        verdict.reason += ": beside " + std::string(Name(best.component)) + " also " + moves;
    } else if (calibration.used_ia == false || calibration.used_n == false) {
      verdict.reason += "; with um alone a double fault cannot be excluded";
    }
  }
  return result;
}

}  // namespace faultlab::core
