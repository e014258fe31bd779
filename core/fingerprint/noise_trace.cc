#include "core/fingerprint/noise_trace.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

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

/// A channel in its span; a missing place is NaN.
std::vector<double> Scaled(const DenseChannel& channel) {
  std::vector<double> scaled(channel.values.size());
  const double span = channel.span > 0.0F ? static_cast<double>(channel.span) : 1.0;
  for (std::size_t k = 0; k < scaled.size(); ++k) {
    scaled[k] =
        (static_cast<double>(channel.values[k]) - static_cast<double>(channel.middle)) / span;
  }
  return scaled;
}

/// By what readings are explained.
class Explanation {
 public:
  /// @param u  held where it is missing
  explicit Explanation(std::vector<double> u) : u_(std::move(u)) {}

  /// By the command and the readings before; nothing where something of it is missing.
  std::optional<Row> At(std::span<const double> y, std::size_t k) const {
    if (k < kLags || std::isnan(y[k])) return std::nullopt;
    if (!slow_.empty()) {
      const std::array<double, 3>& slow = slow_[k];
      return Row{1.0, u_[k], u_[k - 1], u_[k - 2], u_[k - 3], slow[0], slow[1], slow[2]};
    }
    const Row row{1.0, u_[k], u_[k - 1], u_[k - 2], u_[k - 3], y[k - 1], y[k - 2], y[k - 3]};
    if (!row.allFinite()) return std::nullopt;
    return row;
  }

  /// By what the command leaves behind in place of the readings before, where too many of these are
  /// missing. It explains less: only for records that are looked up.
  Explanation ByCommandAlone() const {
    constexpr std::array<double, 3> kSamples = {4.0, 16.0, 64.0};
    Explanation alone(u_);
    alone.slow_.resize(u_.size());
    std::array<double, 3> slow{};
    for (std::size_t k = 0; k < u_.size(); ++k) {
      for (std::size_t i = 0; i < slow.size(); ++i) slow[i] += (u_[k] - slow[i]) / kSamples[i];
      alone.slow_[k] = slow;
    }
    return alone;
  }

 private:
  std::vector<double> u_;
  std::vector<std::array<double, 3>> slow_;
};

/// Whether at most half of the readings have those before them.
bool LacksReadingsBefore(const Explanation& explanation, std::span<const double> y) {
  std::size_t known = 0;
  std::size_t explained = 0;
  for (std::size_t k = kLags; k < y.size(); ++k) {
    if (std::isnan(y[k])) continue;
    ++known;
    if (explanation.At(y, k)) ++explained;
  }
  return 2 * explained <= known;
}

/// What the fit around each sample leaves of its reading; NaN where that is not known.
std::vector<double> ErrorsOf(const Explanation& explanation, std::span<const double> y) {
  const std::size_t size = y.size();
  std::vector<double> errors(size, std::numeric_limits<double>::quiet_NaN());
  Normal normal = Normal::Zero();
  Row right = Row::Zero();
  const auto add = [&](std::size_t k, double sign) {
    const std::optional<Row> row = explanation.At(y, k);
    if (!row) return;
    normal += sign * *row * row->transpose();
    right += (sign * y[k]) * *row;
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
    if (const std::optional<Row> row = explanation.At(y, k)) errors[k] = y[k] - theta.dot(*row);
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
    sizes.clear();
    for (const double error : part) {
      if (!std::isnan(error)) sizes.push_back(std::abs(error));
    }
    const double median = sizes.empty() ? 0.0 : Median(sizes);
    std::fill_n(medians.begin() + static_cast<std::ptrdiff_t>(from), part.size(), median);
  }
  return medians;
}

/// Root mean square of the known errors around each.
std::vector<double> LoudnessOf(std::span<const double> errors) {
  std::vector<double> sums(errors.size() + 1);
  std::vector<double> counts(errors.size() + 1);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const bool known = !std::isnan(errors[k]);
    sums[k + 1] = sums[k] + (known ? errors[k] * errors[k] : 0.0);
    counts[k + 1] = counts[k] + (known ? 1.0 : 0.0);
  }
  std::vector<double> loudness(errors.size());
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const std::size_t from = k < kWindow / 2 ? 0 : k - kWindow / 2;
    const std::size_t to = std::min(errors.size(), k + kWindow / 2);
    const double count = counts[to] - counts[from];
    if (count > 0.0) loudness[k] = std::sqrt((sums[to] - sums[from]) / count);
  }
  return loudness;
}

/// The reading without single ones that are far off, which would blind the fit around them.
std::vector<double> WithoutOutliers(const Explanation& explanation, std::vector<double> y) {
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::vector<double> errors = ErrorsOf(explanation, y);
    const std::vector<double> usual = MediansOf(errors);
    bool any = false;
    for (std::size_t k = 0; k < y.size(); ++k) {
      if (std::isnan(errors[k]) || std::abs(errors[k]) <= kOutlier * usual[k]) continue;
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
    if (std::isnan(errors[k]) || loudness[k] < kSilent || loudness[k] > most) continue;
    constexpr double kMost = kTraceMost;
    const double error = std::clamp(errors[k] / loudness[k], -kMost, kMost);
    trace[k] = static_cast<std::int8_t>(std::lround(kTraceUnit * error));
  }
  return trace;
}

}  // namespace

NoiseTraces TracesOf(const DenseRecord& record, Surprises surprises) {
  std::vector<double> command = Scaled(record.uc);
  double newest = 0.0;
  for (double& u : command) newest = u = std::isnan(u) ? newest : u;
  const Explanation usual(std::move(command));
  NoiseTraces traces;
  for (std::size_t c = 0; c < traces.size(); ++c) {
    if (record.channels[c].span <= 0.0F) continue;
    std::vector<double> readings = Scaled(record.channels[c]);
    if (surprises == Surprises::kLeftOut) {
      traces[c] = TraceOf(ErrorsOf(usual, readings), surprises);
      continue;
    }
    const Explanation explanation =
        LacksReadingsBefore(usual, readings) ? usual.ByCommandAlone() : usual;
    readings = WithoutOutliers(explanation, std::move(readings));
    traces[c] = TraceOf(ErrorsOf(explanation, readings), surprises);
  }
  return traces;
}

}  // namespace faultlab::core
