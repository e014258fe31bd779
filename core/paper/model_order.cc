#include "core/paper/model_order.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "core/plant/coefficients.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {
namespace {

/// The 95 % level of chi-square, to 0.1 % from 5 degrees of freedom on (Wilson, Hilferty, 1931).
double ChiSquare95(int degrees) {
  constexpr double kNormal95 = 1.6449;
  const double part = 2.0 / (9.0 * degrees);
  return degrees * std::pow(1.0 - part + kNormal95 * std::sqrt(part), 3);
}

/// In powers of 1/z: the sum over j of c[j] ((1 - 1/z) / T)^j (1/z)^(n-j), n = size - 1.
std::vector<double> ByForwardDifferences(std::span<const double> c, double period_s) {
  const std::size_t n = c.size() - 1;
  std::vector<double> sum(n + 1, 0.0);
  std::vector<double> power = {1.0};  // (1 - 1/z)^j
  double scale = 1.0;
  for (std::size_t j = 0; j <= n; ++j) {
    for (std::size_t i = 0; i < power.size(); ++i) sum[n - j + i] += c[j] * scale * power[i];
    power.push_back(0.0);
    for (std::size_t i = power.size() - 1; i > 0; --i) power[i] -= power[i - 1];
    scale /= period_s;
  }
  return sum;
}

/// The residual of each row; NaN where it has none.
std::vector<double> ResidualsOf(const DifferenceEquation& equation,
                                std::span<const Sample> stretch,
                                EstimatedChannel channel) {
  const std::size_t n = equation.a.size();
  std::vector<double> residuals;
  std::size_t good = 0;  // rows in a row
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    const bool follows = k > 0 && stretch[k].index == stretch[k - 1].index + 1;
    const bool read =
        std::isfinite(stretch[k].uc_v) && std::isfinite(ReadingOf(stretch[k], channel));
    good = read ? (follows ? good : 0) + 1 : 0;
    if (good <= kOrderMax) {
      residuals.push_back(kAbsent);
      continue;
    }
    double predicted = equation.offset + equation.b[0] * stretch[k].uc_v;
    for (std::size_t i = 1; i <= n; ++i) {
      predicted += equation.b[i] * stretch[k - i].uc_v -
                   equation.a[i - 1] * ReadingOf(stretch[k - i], channel);
    }
    residuals.push_back(ReadingOf(stretch[k], channel) - predicted);
  }
  return residuals;
}

}  // namespace

DifferenceEquation DifferenceOf(const VariantSpec& spec, std::span<const double> theta) {
  const auto n = static_cast<std::size_t>(spec.order);
  DifferenceEquation out;
  out.b.assign(theta.begin(), theta.begin() + spec.order + 1);
  out.a.assign(theta.begin() + spec.order + 1, theta.begin() + 2 * spec.order + 1);
  if (spec.affine || spec.instrumental) out.offset = theta[2 * n + 1];
  if (spec.method == EstimatorMethod::kSwa) return out;
  if (spec.sia_mode == SiaMode::kExact) {
    if (!(out.a[0] > 0.0)) return {{kAbsent, kAbsent}, {kAbsent}, kAbsent};
    const DiscreteCoefficients exact =
        Discretise({out.b[0], out.b[1], out.a[0], 0.0, 0.0}, spec.period_s, spec.delta_s);
    return {{exact.b0d, exact.b1d}, {exact.a1d}, out.offset * (1.0 + exact.a1d)};
  }
  std::vector<double> whole = out.a;  // 1, a1 .. an
  whole.insert(whole.begin(), 1.0);
  const std::vector<double> y = ByForwardDifferences(whole, spec.period_s);
  const std::vector<double> u = ByForwardDifferences(out.b, spec.period_s);
  for (std::size_t i = 0; i <= n; ++i) out.b[i] = u[i] / y[0];
  for (std::size_t i = 1; i <= n; ++i) out.a[i - 1] = y[i] / y[0];
  out.offset /= y[0];
  return out;
}

OrderEvidence JudgeOrder(const VariantSpec& spec,
                         std::span<const double> theta,
                         std::span<const Sample> stretch) {
  const std::vector<double> residuals =
      ResidualsOf(DifferenceOf(spec, theta), stretch, spec.channel);
  const int parameters = static_cast<int>(ParameterNames(spec).size());
  constexpr int kLags = OrderEvidence::kLags;
  OrderEvidence evidence;
  double sum = 0.0;
  double square = 0.0;
  for (const double e : residuals) {
    if (!std::isfinite(e)) continue;
    sum += e;
    square += e * e;
    ++evidence.count;
  }
  evidence.rms = evidence.ljung_box = evidence.bic = kAbsent;
  evidence.white_below = ChiSquare95(kLags - spec.order);
  if (evidence.count < 2 * kLags) return evidence;
  const double n = evidence.count;
  const double mean = sum / n;
  // Sum of the products at a lag, and their number.
  const auto products = [&](std::size_t lag) {
    std::pair<double, double> sums{};
    for (std::size_t k = lag; k < residuals.size(); ++k) {
      const double both = (residuals[k] - mean) * (residuals[k - lag] - mean);
      if (!std::isfinite(both)) continue;
      sums.first += both;
      sums.second += 1.0;
    }
    return sums;
  };
  const double variance = products(0).first;
  if (!(variance > 0.0)) return evidence;
  evidence.rms = std::sqrt(square / n);
  evidence.ljung_box = 0.0;
  for (int lag = 1; lag <= kLags; ++lag) {
    const auto [sum_of, pairs] = products(static_cast<std::size_t>(lag));
    if (pairs > 0.0) evidence.ljung_box += n * (n + 2.0) * std::pow(sum_of / variance, 2) / pairs;
  }
  evidence.bic = n * std::log(square / n) + parameters * std::log(n);
  return evidence;
}

}  // namespace faultlab::core
