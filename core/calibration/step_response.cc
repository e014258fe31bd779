#include "core/calibration/step_response.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/types/check.h"
#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

// A motor turns when its speed is above this share of the largest.
constexpr double kTurns = 0.05;
constexpr std::size_t kRowsMin = 20;
// Fewer rows may be lost readings, or the way to the other direction.
constexpr std::size_t kStandsRows = 10;
// A step is over long before; a record of a million rows costs no more than this many.
constexpr std::size_t kRowsMax = 10'000;
// Of the variation of n; less is no response of first order.
constexpr double kExplainedMin = 0.9;
// Of what the input has to explain.
constexpr double kByInputMin = 0.5;
// Of the square of n, of a speed that is steady but for its readings.
constexpr double kSteadyMost = 0.04;
// From its first half to its second one, of the speed.
constexpr double kDriftMost = 0.02;
// Of the square of n; less is rounding.
constexpr double kMovesMin = 1e-9;
// Time constants are searched from a share of the period to a share of the record.
constexpr double kShortest = 0.3;
constexpr double kLongest = 0.5;
constexpr int kScanPoints = 60;
constexpr int kSections = 20;  // to a thousandth of a scan's step

struct Record {
  std::vector<double> uc_v;
  std::vector<double> n_rpm;
  std::vector<double> periods;  ///< to the next row: more than 1 where rows are missing
  bool steps = false;           ///< uc has more than one level
  bool begins = false;          ///< from rest
};

/// From the row on at which the motor turns, without rows that lack a reading.
/// @param of_row_before  ReadingRules::of_row_before
Record TurningPart(std::span<const Sample> samples, bool of_row_before) {
  double most = 0.0;
  for (const Sample& sample : samples) {
    if (std::isfinite(sample.n_rpm)) most = std::max(most, std::abs(sample.n_rpm));
  }
  Record record;
  std::int64_t last = 0;
  double before_v = kAbsent;
  std::size_t standing = 0;
  for (const Sample& sample : samples) {
    const double row_before_v = std::exchange(before_v, sample.uc_v);
    const double uc_v = of_row_before ? row_before_v : sample.uc_v;
    if (!std::isfinite(sample.n_rpm) || !std::isfinite(uc_v)) continue;
    const bool stands = std::abs(sample.n_rpm) <= kTurns * most;
    if (record.n_rpm.empty() && stands) continue;
    standing = stands ? standing + 1 : 0;
    if (record.n_rpm.size() == kRowsMax) break;
    if (standing == kStandsRows) {  // friction holds it: from here on it does not answer
      const std::size_t kept = record.uc_v.size() - std::min(record.uc_v.size(), kStandsRows - 1);
      record.uc_v.resize(kept);
      record.n_rpm.resize(kept);
      record.periods.resize(kept > 0 ? kept - 1 : 0);
      break;
    }
    if (!record.uc_v.empty()) record.periods.push_back(static_cast<double>(sample.index - last));
    last = sample.index;
    record.uc_v.push_back(uc_v);
    record.n_rpm.push_back(sample.n_rpm);
  }
  if (record.uc_v.empty()) return record;
  record.periods.push_back(1.0);
  const auto [low, high] = std::ranges::minmax(record.uc_v);
  record.steps = high - low > kTurns * std::max(std::abs(high), std::abs(low));
  record.begins = std::abs(samples.front().n_rpm) <= kTurns * most;
  return record;
}

struct Fit {
  Eigen::MatrixXd regressors;  ///< a constant, the decay of the start, and uc behind the lag
  Eigen::VectorXd theta;
  Eigen::VectorXd left;
};

/// @param share  of a period from the edge of uc to the reading
Fit FitAt(const Record& record, double periods, double share) {
  const auto rows = static_cast<Eigen::Index>(record.n_rpm.size());
  Fit fit;
  fit.regressors.resize(rows, record.steps ? 3 : 2);
  double lagged = record.uc_v.front();
  double decay = 1.0;
  for (Eigen::Index k = 0; k < rows; ++k) {
    fit.regressors(k, 0) = 1.0;
    fit.regressors(k, 1) = decay;
    const double input = record.uc_v[static_cast<std::size_t>(k)];
    const double until_read = std::exp(-share / periods);
    if (record.steps) fit.regressors(k, 2) = until_read * lagged + (1.0 - until_read) * input;
    const double kept = std::exp(-record.periods[static_cast<std::size_t>(k)] / periods);
    lagged = kept * lagged + (1.0 - kept) * input;
    decay *= kept;
  }
  const Eigen::Map<const Eigen::VectorXd> n(record.n_rpm.data(), rows);
  fit.theta = fit.regressors.colPivHouseholderQr().solve(n);
  fit.left = n - fit.regressors * fit.theta;
  return fit;
}

double CostAt(const Record& record, double log_periods, double share) {
  return FitAt(record, std::exp(log_periods), share).left.squaredNorm();
}

/// The logarithm of the time constant in periods: the best of a scan, then golden sections.
double BestTimeConstant(const Record& record, double share) {
  const double low = std::log(kShortest);
  const double high = std::log(std::max(1.0, kLongest * static_cast<double>(record.n_rpm.size())));
  const double step = (high - low) / kScanPoints;
  double best = low;
  double least = CostAt(record, best, share);
  for (int i = 1; i <= kScanPoints; ++i) {
    const double at = low + step * i;
    const double cost = CostAt(record, at, share);
    if (cost >= least) continue;
    best = at;
    least = cost;
  }
  constexpr double kGolden = 0.6180339887498949;
  double a = best - step;
  double b = best + step;
  for (int i = 0; i < kSections; ++i) {
    const double left = b - kGolden * (b - a);
    const double right = a + kGolden * (b - a);
    const bool lower = CostAt(record, left, share) < CostAt(record, right, share);
    (lower ? b : a) = lower ? right : left;
  }
  return 0.5 * (a + b);
}

/// By how much the variance of a mean of correlated residuals is more than that of white ones: what
/// a first order does not describe stays for many rows.
double CorrelationFactor(const Eigen::VectorXd& left) {
  const Eigen::Index n = left.size();
  const double all = left.squaredNorm();
  double factor = 1.0;
  for (Eigen::Index lag = 1; all > 0.0 && lag < n / 4; ++lag) {
    const double correlation = left.head(n - lag).dot(left.tail(n - lag)) / all;
    if (correlation <= 0.0) break;
    factor += 2.0 * correlation;
  }
  return factor;
}

/// Of what a constant and the decay of the start leave, the share that the input explains.
double ExplainedByInput(const Fit& fit, const Eigen::VectorXd& n) {
  const Eigen::MatrixXd others = fit.regressors.leftCols(2);
  const Eigen::VectorXd theta = others.colPivHouseholderQr().solve(n);
  const double left = (n - others * theta).squaredNorm();
  return left > 0.0 ? 1.0 - fit.left.squaredNorm() / left : 0.0;
}

}  // namespace

std::optional<std::string> StepResponseText(std::span<const Sample> samples,
                                            const Bench& bench,
                                            double period_s) {
  LAB_CHECK(period_s > 0.0 && bench.delta_s >= 0.0, period_s, bench.delta_s);
  const double share = std::min(1.0, bench.ReadingDelay(bench.delta_s, period_s) / period_s);
  const Record record = TurningPart(samples, bench.follows_row_before());
  if (record.n_rpm.size() < kRowsMin) return std::nullopt;
  const double log_periods = BestTimeConstant(record, share);
  const Fit fit = FitAt(record, std::exp(log_periods), share);
  const auto rows = static_cast<Eigen::Index>(record.n_rpm.size());
  const Eigen::Map<const Eigen::VectorXd> n(record.n_rpm.data(), rows);
  const double mean_rpm = n.mean();
  const double variation = (n.array() - mean_rpm).matrix().squaredNorm();
  // A counter that stands still reads the same number again and again.
  if (!(variation > kMovesMin * n.squaredNorm())) return std::nullopt;
  if (!(fit.left.squaredNorm() < (1.0 - kExplainedMin) * variation)) {
    // A start of few rows, of a coarse counter: it tells where it settles, not how fast.
    const bool settles =
        !record.steps && record.begins && variation < kSteadyMost * n.squaredNorm();
    const double drifts = std::abs(n.head(rows / 2).mean() - n.tail(rows / 2).mean());
    if (!settles || drifts > kDriftMost * std::abs(mean_rpm)) return std::nullopt;
    const Eigen::VectorXd left = n.array() - mean_rpm;
    return Format(
        "step response: it settles at %.4g +- %.2g rpm under %.4g V; too few rows, or too "
        "coarse, for a time constant",
        mean_rpm,
        std::sqrt(CorrelationFactor(left) * variation) / static_cast<double>(rows),
        record.uc_v.back());
  }
  // A controller that holds the speed hides how the motor answers.
  if (record.steps && ExplainedByInput(fit, n) < kByInputMin) return std::nullopt;

  // The slope by the time constant, beside those by the linear parameters.
  constexpr double kStep = 1e-4;
  Eigen::MatrixXd slopes(rows, fit.regressors.cols() + 1);
  slopes.leftCols(fit.regressors.cols()) = fit.regressors;
  slopes.rightCols(1) = (FitAt(record, std::exp(log_periods + kStep), share).regressors -
                         FitAt(record, std::exp(log_periods - kStep), share).regressors) *
                        fit.theta / (2.0 * kStep);
  const double freedom = static_cast<double>(rows - slopes.cols());
  const double variance = fit.left.squaredNorm() / freedom * CorrelationFactor(fit.left);
  const Eigen::MatrixXd information = slopes.transpose() * slopes;
  const Eigen::VectorXd sigma =
      (variance * information.completeOrthogonalDecomposition().pseudoInverse())
          .diagonal()
          .cwiseMax(0.0)
          .cwiseSqrt();
  const double time_ms = 1e3 * period_s * std::exp(log_periods);
  const double time_sigma_ms = time_ms * sigma(sigma.size() - 1);
  if (!(time_sigma_ms < time_ms)) return std::nullopt;
  if (record.steps) {
    return Format("step response: gain %.4g +- %.2g rpm/V, time constant %.4g +- %.2g ms",
                  fit.theta(2),
                  sigma(2),
                  time_ms,
                  time_sigma_ms);
  }
  return Format(
      "step response: it settles at %.4g +- %.2g rpm under %.4g V, time constant %.4g +- "
      "%.2g ms",
      fit.theta(0),
      sigma(0),
      record.uc_v.back(),
      time_ms,
      time_sigma_ms);
}

}  // namespace faultlab::core
