#include "core/fingerprint/noise_trace.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace faultlab::core {
namespace {

constexpr int kOrder = 8;
using Row = Eigen::Matrix<double, kOrder, 1>;
using Normal = Eigen::Matrix<double, kOrder, kOrder>;

/// Samples around each, of which the fit at this one is made.
constexpr std::size_t kWindow = 64;
constexpr std::size_t kSolvedEvery = 8;
constexpr std::size_t kLags = 3;
/// Of the diagonal of the normal equations: a command that stands still determines less.
constexpr double kRidge = 1e-8;
/// A stretch in which the noise is so many times what it usually is contains more than noise.
constexpr double kLoud = 1.6;
/// Less than this share of what a channel does is no noise, but how numbers are rounded.
constexpr double kSilent = 1e-5;
/// In medians of the sizes: 6 standard deviations.
constexpr double kOutlier = 9.0;
constexpr int kPasses = 3;

/// Mean and standard deviation of the finite ones; sd 0: there are none, or all are the same.
struct Scale {
  double mean = 0.0;
  double sd = 0.0;

  double Of(double value) const { return (value - mean) / sd; }
};

Scale ScaleOf(std::span<const Sample> samples, double Sample::*channel) {
  double sum = 0.0;
  double count = 0.0;
  for (const Sample& sample : samples) {
    if (!std::isfinite(sample.*channel)) continue;
    sum += sample.*channel;
    count += 1.0;
  }
  if (count == 0.0) return {};
  Scale scale{sum / count, 0.0};
  double squares = 0.0;
  for (const Sample& sample : samples) {
    const double off = sample.*channel - scale.mean;
    if (std::isfinite(off)) squares += off * off;
  }
  scale.sd = std::sqrt(squares / count);
  return scale;
}

/// Of one channel, in its standard deviations; a reading that is missing is the one before it.
std::vector<double> Scaled(std::span<const Sample> samples,
                           double Sample::*channel,
                           const Scale& scale) {
  std::vector<double> readings(samples.size());
  double newest = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (std::isfinite(samples[k].*channel)) newest = scale.Of(samples[k].*channel);
    readings[k] = newest;
  }
  return readings;
}

/// What the fit around each sample leaves of its reading.
std::vector<double> ErrorsOf(std::span<const double> u, std::span<const double> y) {
  const std::size_t size = y.size();
  std::vector<double> errors(size);
  std::vector<Row> rows(size, Row::Zero());
  for (std::size_t k = kLags; k < size; ++k) {
    rows[k] << 1.0, u[k], u[k - 1], u[k - 2], u[k - 3], y[k - 1], y[k - 2], y[k - 3];
  }
  Normal normal = Normal::Zero();
  Row right = Row::Zero();
  const auto add = [&](std::size_t k, double sign) {
    normal += sign * rows[k] * rows[k].transpose();
    right += (sign * y[k]) * rows[k];
  };
  Row theta = Row::Zero();
  std::size_t from = 0;
  std::size_t to = 0;
  for (; to < std::min(kWindow, size); ++to) add(to, 1.0);
  for (std::size_t k = 0; k < size; ++k) {
    if (to < size && k >= from + kWindow / 2) {
      add(to++, 1.0);
      add(from++, -1.0);
    }
    if (k % kSolvedEvery == 0) {
      Normal solved = normal;
      solved.diagonal() *= 1.0 + kRidge;
      solved.diagonal().array() += kRidge;
      theta = solved.llt().solve(right);
    }
    errors[k] = k < kLags ? 0.0 : y[k] - theta.dot(rows[k]);
  }
  return errors;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Of the sizes of the errors in each kWindow of them.
std::vector<double> MediansOf(std::span<const double> errors) {
  std::vector<double> medians(errors.size());
  std::vector<double> sizes;
  for (std::size_t from = 0; from < errors.size(); from += kWindow) {
    const auto part = errors.subspan(from, std::min(kWindow, errors.size() - from));
    sizes.assign(part.size(), 0.0);
    std::ranges::transform(part, sizes.begin(), [](double error) { return std::abs(error); });
    const double median = Median(sizes);
    std::fill_n(medians.begin() + static_cast<std::ptrdiff_t>(from), part.size(), median);
  }
  return medians;
}

/// Root mean square of the errors around each.
std::vector<double> LoudnessOf(std::span<const double> errors) {
  std::vector<double> sums(errors.size() + 1);
  for (std::size_t k = 0; k < errors.size(); ++k) sums[k + 1] = sums[k] + errors[k] * errors[k];
  std::vector<double> loudness(errors.size());
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const std::size_t from = k < kWindow / 2 ? 0 : k - kWindow / 2;
    const std::size_t to = std::min(errors.size(), k + kWindow / 2);
    loudness[k] = std::sqrt((sums[to] - sums[from]) / static_cast<double>(to - from));
  }
  return loudness;
}

/// The reading without single ones that are far off, which would blind the fit around them.
std::vector<double> WithoutOutliers(std::span<const double> u, std::vector<double> y) {
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::vector<double> errors = ErrorsOf(u, y);
    const std::vector<double> usual = MediansOf(errors);
    bool any = false;
    for (std::size_t k = 0; k < y.size(); ++k) {
      if (std::abs(errors[k]) <= kOutlier * usual[k]) continue;
      y[k] -= errors[k];
      any = true;
    }
    if (!any) break;
  }
  return y;
}

NoiseTrace TraceOf(std::span<const double> errors, Surprises surprises) {
  if (errors.empty()) return {};
  const std::vector<double> loudness = LoudnessOf(errors);
  const double most = surprises == Surprises::kLeftOut ? kLoud * Median(loudness) : INFINITY;
  NoiseTrace trace(errors.size());
  for (std::size_t k = 0; k < errors.size(); ++k) {
    if (loudness[k] < kSilent || loudness[k] > most) continue;
    constexpr double kMost = kTraceMost;
    const double error = std::clamp(errors[k] / loudness[k], -kMost, kMost);
    trace[k] = static_cast<std::int8_t>(std::lround(kTraceUnit * error));
  }
  return trace;
}

}  // namespace

std::array<NoiseTrace, kTracedChannels.size()> TracesOf(std::span<const Sample> samples,
                                                        Surprises surprises) {
  Scale command_scale = ScaleOf(samples, &Sample::uc_v);
  if (command_scale.sd == 0.0) command_scale.sd = 1.0;
  const std::vector<double> command = Scaled(samples, &Sample::uc_v, command_scale);
  std::array<NoiseTrace, kTracedChannels.size()> traces;
  for (std::size_t c = 0; c < traces.size(); ++c) {
    const Scale scale = ScaleOf(samples, kTracedChannels[c]);
    if (scale.sd == 0.0) continue;
    std::vector<double> readings = Scaled(samples, kTracedChannels[c], scale);
    if (surprises == Surprises::kKept) readings = WithoutOutliers(command, std::move(readings));
    traces[c] = TraceOf(ErrorsOf(command, readings), surprises);
  }
  return traces;
}

}  // namespace faultlab::core
