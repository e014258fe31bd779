#include "core/filter/find_hum.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "core/filter/innovation_filter.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

// um and ia can have hum, a counted speed cannot.
constexpr std::size_t kHumChannels = 2;
constexpr std::array<double, 2> kMainsHz = {50.0, 60.0};
constexpr double kMainsOffHz = 0.5;
// A stretch of seconds tells frequencies apart by some tenths of a hertz; then as finely as it can.
constexpr double kScanHz = 0.02;
constexpr double kRefineHz = 0.001;
// Slower than this after sampling, hum is a drift, of which other parts of the model know more.
constexpr double kAliasMinHz = 2.0;
constexpr double kClip = 4.0;
// How large hum is; what a short stretch does not tell of it stays within.
constexpr std::array<double, kHumChannels> kUsual = {0.05, 0.005};

double AliasHz(double frequency_hz, double period_s) {
  const double turns = frequency_hz * period_s;
  return std::abs(turns - std::round(turns)) / period_s;
}

/// Whitened innovations of all channels, each clipped.
Eigen::VectorXd Clipped(const InnovationTrace& trace, std::span<const Observation> stretch) {
  Eigen::VectorXd z = Eigen::Map<const Eigen::VectorXd>(
      trace.whitened.data(), static_cast<Eigen::Index>(trace.whitened.size()));
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    const std::vector<double> sizes = SortedMagnitudes(trace, stretch, c);
    if (sizes.empty()) continue;
    const double most = kClip * RobustSigma(sizes);
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      double& each = z(static_cast<Eigen::Index>(k * kOutputCount + c));
      each = std::clamp(each, -most, most);
    }
  }
  return z;
}

class Search {
 public:
  Search(const PredictionModel& model,
         std::span<const Observation> stretch,
         std::span<const double> t_s)
      : model_(model), stretch_(stretch), t_s_(t_s) {
    RunInnovations(model_, stretch_, &trace_);
    z_ = Clipped(trace_, stretch_);
  }

  /// Chi-square that a sinusoid in the innovations of each channel explains.
  double Gain(double frequency_hz) const {
    const double w = 2.0 * std::numbers::pi * frequency_hz;
    std::array<double, kHumChannels> cc{}, ss{}, cs{}, cz{}, sz{};
    for (std::size_t k = 0; k < stretch_.size(); ++k) {
      const double c = std::cos(w * t_s_[k]);
      const double s = std::sin(w * t_s_[k]);
      for (std::size_t i = 0; i < kHumChannels; ++i) {
        if (((stretch_[k].mask >> i) & 1U) == 0U) continue;
        const double z = z_(static_cast<Eigen::Index>(k * kOutputCount + i));
        cc[i] += c * c;
        ss[i] += s * s;
        cs[i] += c * s;
        cz[i] += c * z;
        sz[i] += s * z;
      }
    }
    double gain = 0.0;
    for (std::size_t i = 0; i < kHumChannels; ++i) {
      // Where the sampling shows only one of the two, the other is left out.
      const double a = cc[i] + 1.0;
      const double b = ss[i] + 1.0;
      const double det = a * b - cs[i] * cs[i];
      gain += (b * cz[i] * cz[i] - 2.0 * cs[i] * cz[i] * sz[i] + a * sz[i] * sz[i]) / det;
    }
    return gain;
  }

  /// The phasors of least squares, and of `gain` what they explain in the filter itself.
  Hum At(double frequency_hz, double& gain) const {
    const double w = 2.0 * std::numbers::pi * frequency_hz;
    Eigen::MatrixXd response(z_.size(), 2 * kHumChannels);
    std::vector<Observation> with(stretch_.begin(), stretch_.end());
    InnovationTrace moved;
    for (std::size_t column = 0; column < 2 * kHumChannels; ++column) {
      const std::size_t channel = column / 2;
      const bool cosine = column % 2 == 0;
      for (std::size_t k = 0; k < with.size(); ++k) {
        const double phase = w * t_s_[k];
        with[k].y[channel] =
            stretch_[k].y[channel] + kUsual[channel] * (cosine ? std::cos(phase) : std::sin(phase));
      }
      RunInnovations(model_, with, &moved);
      for (std::size_t k = 0; k < with.size(); ++k) with[k].y[channel] = stretch_[k].y[channel];
      for (Eigen::Index row = 0; row < z_.size(); ++row) {
        response(row, static_cast<Eigen::Index>(column)) =
            moved.whitened[static_cast<std::size_t>(row)] -
            trace_.whitened[static_cast<std::size_t>(row)];
      }
    }
    using Square = Eigen::Matrix<double, 2 * kHumChannels, 2 * kHumChannels>;
    const Square information = response.transpose() * response + Square::Identity();
    const Eigen::Matrix<double, 2 * kHumChannels, 1> slope = response.transpose() * z_;
    const Eigen::Matrix<double, 2 * kHumChannels, 1> p = information.ldlt().solve(slope);
    gain = p.dot(slope);
    return {
        frequency_hz, {p(0) * kUsual[0], p(1) * kUsual[0]}, {p(2) * kUsual[1], p(3) * kUsual[1]}};
  }

 private:
  const PredictionModel& model_;
  std::span<const Observation> stretch_;
  std::span<const double> t_s_;
  InnovationTrace trace_;
  Eigen::VectorXd z_;
};

}  // namespace

Hum FindHum(const PredictionModel& model,
            std::span<const Observation> stretch,
            std::span<const double> t_s,
            double period_s,
            double gain_min) {
  LAB_CHECK(stretch.size() == t_s.size(), stretch.size(), t_s.size());
  const bool read = std::any_of(stretch.begin(), stretch.end(), [](const Observation& o) {
    return (o.mask & ((1U << kHumChannels) - 1U)) != 0U;
  });
  if (!read) return {};
  const Search search(model, stretch, t_s);
  double best_hz = 0.0;
  double best = gain_min;
  const auto scan = [&](double from_hz, double to_hz, double step_hz) {
    const auto steps = static_cast<int>(std::lround((to_hz - from_hz) / step_hz));
    for (int i = 0; i <= steps; ++i) {
      const double hz = from_hz + i * step_hz;
      const double gain = search.Gain(hz);
      if (gain <= best) continue;
      best = gain;
      best_hz = hz;
    }
  };
  for (const double mains : kMainsHz) {
    if (AliasHz(mains, period_s) < kAliasMinHz) continue;
    scan(mains - kMainsOffHz, mains + kMainsOffHz, kScanHz);
  }
  if (best_hz <= 0.0) return {};
  scan(best_hz - kScanHz, best_hz + kScanHz, kRefineHz);
  double gain = 0.0;
  const Hum hum = search.At(best_hz, gain);
  return gain > gain_min ? hum : Hum{};
}

}  // namespace faultlab::core
