#include "core/detection/detector.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/detection/directions.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// After a start or a gap the gains are computed step by step for three times the slowest time
// constant, which is that of the slow friction torque.
constexpr double kFindingTimeConstants = 3.0;
// Log likelihood ratio of one innovation between variance 4 and variance 1. Smaller changes are
// left to the GLRs, which know the shape of the response.
constexpr double kCusumSlope = 0.5 * (1.0 - 1.0 / 4.0);
constexpr double kCusumCost = std::numbers::ln2;
// If |z| of the sample that raises the alarm exceeds this, that sample is itself faulty.
constexpr double kSharp = 5.0;

// Until the state is found again after a gap, samples at 100 Hz. It begins far from where it is,
// which looks like a change that all gaps share.
constexpr std::size_t kLost = 10;

}  // namespace

Detector::Detector(const Bench& bench,
                   const RigParameters& reference,
                   const NoiseLevel& noise,
                   double period_s,
                   unsigned mask,
                   const DetectionThresholds& thresholds,
                   int reference_samples,
                   const NoiseScale& noise_scale,
                   double speed_step_s,
                   bool impulses,
                   const ModelError& error)
    : models_used_(error.walks() ? kWalkModels + kWalking : kWalkModels),
      speed_step_s_(speed_step_s),
      impulses_(impulses),
      recursion_(models_[0].model),
      finding_samples_max_(
          static_cast<int>(std::lround(kFindingTimeConstants * noise.friction_tau_s / period_s))),
      short_samples_(static_cast<int>(SpanOf(kShort, period_s))),
      long_samples_(static_cast<int>(SpanOf(kLong, period_s))),
      lost_samples_(static_cast<int>(SpanOf(kLost, period_s))),
      passage_samples_(std::min(finding_samples_max_ - 1, short_samples_)),
      forget_(1.0 - 1.0 / static_cast<double>(SpanOf(kSlow, period_s))),
      thresholds_(thresholds),
      noise_scale_(noise_scale),
      ring_(SpanOf(kLong, period_s)),
      error_(error) {
  models_[0].model = MakePredictionModel(reference, noise, period_s);
  for (int j = 0; j < kDirections; ++j) {
    models_[static_cast<std::size_t>(j + 1)].model =
        MakePredictionModel(ChangedIn(bench, reference, j), noise, period_s);
  }
  for (std::size_t w = 0; w < kWalking; ++w) {
    ParameterOffsets q{};
    q[static_cast<std::size_t>(kWarmingParts[w].coordinate)] = error.walk[w];
    models_[kWalkModels + w].model =
        MakePredictionModel(WithOffsets(reference, q, period_s), noise, period_s);
  }
  for (const Model& m : models_) limited_ = limited_ || m.model.limited();
  settled_ = SteadyStateGains(models_[0].model, mask);
  reference_samples_ = std::max(50, reference_samples);
  inflation_short_ = 1.0 + short_samples_ / reference_samples_;
  inflation_long_ = 1.0 + long_samples_ / reference_samples_;
}

void Detector::Restart(const Observation& observation) {
  for (Model& m : models_) {
    m.x = TurningState(m.model, observation.u);
    m.friction.direction = m.model.holds() && m.x(2) < 0.0 ? -1.0 : 1.0;
  }
  recursion_.Restart();
  finding_samples_ = finding_samples_max_;
  cusum_ = 0.0;
  cusum_age_ = 0;
  odd_.Restart();
  lost_ = filled_ > 0 ? lost_samples_ : 0;
}

double Detector::PassageVariance(const Observation& o) const {
  const PredictionModel& m = models_[0].model;
  if (!m.holds() || o.restart) return 0.0;
  FrictionStep friction;
  (void)Step(m, models_[0].x, m.Limited(o.u_prev), m.Limited(o.u), friction);
  return friction.passage_variance;
}

const ChannelGains& Detector::Gains(unsigned use, double passage_variance) {
  if (passage_variance > 0.0) finding_samples_ = std::max(finding_samples_, passage_samples_);
  if (finding_samples_ == 0) return settled_;
  if (finding_samples_ < finding_samples_max_) recursion_.Predict();
  recursion_.WidenSpeed(passage_variance);
  --finding_samples_;
  for (int channel = 0; channel < kOutputCount; ++channel) {
    const auto c = static_cast<std::size_t>(channel);
    if ((use & (1U << channel)) == 0U) continue;
    finding_.inverse_sd[c] = 1.0 / std::sqrt(recursion_.Correct(channel, finding_.gain[c]));
  }
  return finding_;
}

ChannelGains Detector::WithRounding(const ChannelGains& gains, double speed_rad_s) const {
  ChannelGains coarser = gains;
  const double s = 1.0 / (gains.inverse_sd[2] * gains.inverse_sd[2]);
  const double share = s / (s + RoundingVariance(speed_rad_s, speed_step_s_));
  coarser.gain[2] *= share;
  coarser.inverse_sd[2] *= std::sqrt(share);
  return coarser;
}

void Detector::Whiten(const Observation& o, const ChannelGains& gains, Whitened& z, unsigned use) {
  for (std::size_t i = 0; i < models_used_; ++i) {
    const PredictionModel& m = models_[i].model;
    Eigen::Vector4d& x = models_[i].x;
    const double u = limited_ ? m.Limited(o.u) : o.u;
    if (!o.restart) {
      const double u_prev = limited_ ? m.Limited(o.u_prev) : o.u_prev;
      const Eigen::Vector4d next = Step(m, x, u_prev, u, models_[i].friction);
      x = next;
    }
    const double turned = models_[i].friction.direction - 1.0;
    z[i] = {};
    const auto correct = [&](std::size_t c, double e) {
      x += gains.gain[c] * e;
      if (turned != 0.0) x(3) += turned * gains.gain[c](3) * e;  // the gains are of s = 1
      z[i][c] = e * inverse_sd_[c];
    };
    // um is made of two states and the input; the other readings are states.
    if ((use & 1U) != 0U) correct(0, o.y[0] - (m.c(0, 0) * x(0) + m.c(0, 1) * x(1)) - m.d(0) * u);
    if ((use & 2U) != 0U) correct(1, o.y[1] - x(1));
    if ((use & 4U) != 0U) correct(2, o.y[2] - x(2));
  }
}

unsigned Detector::FarOff(const Observation& o, unsigned use) const {
  const PredictionModel& m = models_[0].model;
  const double u = m.Limited(o.u);
  FrictionStep friction = models_[0].friction;
  const Eigen::Vector4d x =
      o.restart ? models_[0].x : Step(m, models_[0].x, m.Limited(o.u_prev), u, friction);
  unsigned far = 0;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if (((use >> c) & 1U) == 0U) continue;
    const auto row = static_cast<Eigen::Index>(c);
    const double e = o.y[c] - m.c.row(row).dot(x) - m.d(row) * u;
    if (std::abs(e) * inverse_sd_[c] * noise_scale_.Weight(c) > kImpulseGate) far |= 1U << c;
  }
  return far;
}

void Detector::Slide(const Cell& newest, const Cell& leaving, Products<double>& sum) const {
  const auto slide = [](const auto& in, const auto& out, auto& of) {
    for (std::size_t j = 0; j < kDirections; ++j) of[j] += static_cast<double>(in[j]) - out[j];
  };
  slide(newest.cross, leaving.cross, sum.cross);
  slide(newest.square, leaving.square, sum.square);
  for (std::size_t w = 0; walks() && w < kWalking; ++w) {
    slide(newest.with_walk[w], leaving.with_walk[w], sum.with_walk[w]);
  }
}

void Detector::Forget(const Cell& newest, Products<double>& sum) const {
  const auto forget = [](double factor, const auto& in, auto& of) {
    for (std::size_t j = 0; j < kDirections; ++j) of[j] = factor * of[j] + in[j];
  };
  forget(forget_, newest.cross, sum.cross);
  forget(forget_ * forget_, newest.square, sum.square);
  for (std::size_t w = 0; walks() && w < kWalking; ++w) {
    forget(forget_, newest.with_walk[w], sum.with_walk[w]);
  }
}

double Detector::Glr(const Products<double>& sum, std::size_t direction) const {
  double variance = sum.square[direction];
  if (!(variance > 0.0)) return 0.0;
  for (std::size_t w = 0; walks() && w < kWalking; ++w) {
    variance += sum.with_walk[w][direction] * sum.with_walk[w][direction];
  }
  return sum.cross[direction] * sum.cross[direction] / variance;
}

std::optional<Alarm> Detector::Push(const Observation& o) {
  if (o.restart) Restart(o);
  unsigned use = o.mask;
  if (o.clipped != 0) {
    const PredictionModel& m = models_[0].model;
    const double u = m.Limited(o.u);
    const Eigen::Vector4d next = Step(m, models_[0].x, m.Limited(o.u_prev), u);
    const double predicted = m.c.row(0).dot(next) + m.d(0) * u;
    // At the rail a reading is a bound: no news when the prediction lies beyond it.
    if (predicted * o.clipped >= o.y[0] * o.clipped) use &= ~1U;
  }
  Whitened z;
  const bool coarse = speed_step_s_ > 0.0 && (use & 4U) != 0U;
  const ChannelGains* gains = &Gains(use, PassageVariance(o));
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    inverse_sd_[c] = gains->inverse_sd[c] * o.trust[c];
  }
  if (impulses_) {
    const unsigned far = FarOff(o, use);
    use &= ~far;
    odd_.Push(far != 0U);
  }
  ChannelGains coarser;
  if (coarse) {
    coarser = WithRounding(*gains, o.y[2]);
    inverse_sd_[2] *= coarser.inverse_sd[2] / gains->inverse_sd[2];
    gains = &coarser;
  }
  Whiten(o, *gains, z, use);
  whitened_ = z[0];

  double largest = 0.0;
  double step = 0.0;
  Cell cell;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if ((use & (1U << c)) == 0U) continue;
    const double weight = noise_scale_.Weight(c);
    const double r = z[0][c] * weight;
    noise_scale_.Push(c, z[0][c]);
    Eigen::Vector3d walk = Eigen::Vector3d::Zero();
    double alone = r;
    if (walks()) {
      for (std::size_t w = 0; w < kWalking; ++w) {
        walk(static_cast<Eigen::Index>(w)) = r - z[kWalkModels + w][c] * weight;
      }
      alone = (r - walk.dot(walked_.at)) / std::sqrt(1.0 + walk.squaredNorm());
      if (lost_ == 0) {
        walked_.square += walk * walk.transpose();
        walked_.cross += walk * r;
      }
    }
    largest = std::max(largest, std::abs(alone));
    step += kCusumSlope * alone * alone - kCusumCost;
    if (lost_ > 0) continue;
    for (std::size_t j = 0; j < kDirections; ++j) {
      const double s = r - z[j + 1][c] * weight;
      cell.cross[j] += static_cast<float>(s * r);
      cell.square[j] += static_cast<float>(s * s);
      for (std::size_t w = 0; walks() && w < kWalking; ++w) {
        cell.with_walk[w][j] += static_cast<float>(s * walk(static_cast<Eigen::Index>(w)));
      }
    }
  }
  if (walks()) {
    walked_.at = walked_.square.ldlt().solve(walked_.cross);
    walked_.cross *= forget_;
    walked_.square = forget_ * walked_.square + (1.0 - forget_) * Eigen::Matrix3d::Identity();
  }
  lost_ = std::max(0, lost_ - 1);
  cusum_ = std::max(0.0, cusum_ + step);
  cusum_age_ = cusum_ > 0.0 ? cusum_age_ + 1 : 0;

  Cell& oldest = ring_[static_cast<std::size_t>(head_)];
  int leaving_at = head_ - short_samples_;
  if (leaving_at < 0) leaving_at += long_samples_;
  Slide(cell, ring_[static_cast<std::size_t>(leaving_at)], short_);
  Slide(cell, oldest, long_);
  Forget(cell, slow_);
  slow_weight_ = forget_ * slow_weight_ + 1.0;
  slow_weight_square_ = forget_ * forget_ * slow_weight_square_ + 1.0;
  oldest = cell;
  if (++head_ == long_samples_) head_ = 0;
  filled_ = std::min(filled_ + 1, long_samples_);

  const double inflation = noise_scale_.threshold_inflation();
  largest /= std::sqrt(inflation);
  const double inflation_slow =
      1.0 + slow_weight_ * slow_weight_ / (slow_weight_square_ * reference_samples_);
  std::array<double, 3> glr{};
  for (std::size_t j = 0; j < kDirections; ++j) {
    const std::array<double, 3> of = {Glr(short_, j), Glr(long_, j), Glr(slow_, j)};
    for (std::size_t w = 0; w < of.size(); ++w) {
      directions_[w][j] = of[w] / error_.raised[w][j];
      glr[w] = std::max(glr[w], directions_[w][j]);
    }
  }
  const std::array<double, 3> by = {
      inflation_short_ * inflation, inflation_long_ * inflation, inflation_slow * inflation};
  for (std::size_t w = 0; w < by.size(); ++w) {
    glr[w] /= by[w];
    for (double& of : directions_[w]) of /= by[w];
  }
  const auto [glr_short, glr_long, glr_slow] = glr;
  const double cusum = cusum_ / inflation;
  statistics_ = {largest, cusum, glr_short, glr_long, glr_slow};

  Alarm alarm;
  if (odd_.passed()) {
    alarm = {"residual", odd_.statistic(), RowOfOddSamples::kLevel, 0, true};
  } else if (!impulses_ && largest > thresholds_.residual) {
    alarm = {"residual", largest, thresholds_.residual, 0, true};
  } else if (cusum > thresholds_.cusum) {
    alarm = {"cusum", cusum, thresholds_.cusum, 0, largest > kSharp};
  } else if (glr_short > thresholds_.glr_short) {
    alarm = {"glr_25", glr_short, thresholds_.glr_short, 0, false};
  } else if (glr_long > thresholds_.glr_long) {
    alarm = {"glr_100", glr_long, thresholds_.glr_long, 0, false};
  } else if (glr_slow > thresholds_.glr_slow) {
    alarm = {"glr_500", glr_slow, thresholds_.glr_slow, 0, false};
  } else {
    return std::nullopt;
  }
  alarm.samples_ago = odd_.passed() ? RowOfOddSamples::kSamples - 1 : OnsetSamplesAgo();
  if (alarm.detector[0] == 'c') alarm.samples_ago = std::max(alarm.samples_ago, cusum_age_ - 1);
  return alarm;
}

std::array<double, kOutputCount> Detector::BoundedInnovations() const {
  constexpr double kBound = 4.0;
  std::array<double, kOutputCount> e{};
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if (inverse_sd_[c] <= 0.0) continue;
    const double most = kBound / settled_.inverse_sd[c];
    e[c] = std::clamp(whitened_[c] / inverse_sd_[c], -most, most);
  }
  return e;
}

int Detector::OnsetSamplesAgo() const {
  // Finds the start k that maximises (sum from k of s z)^2 / (sum of s^2) over all directions.
  std::array<double, kDirections> cross{};
  std::array<double, kDirections> square{};
  double best = 0.0;
  int ago = 0;
  for (int back = 0; back < filled_; ++back) {
    const Cell& cell =
        ring_[static_cast<std::size_t>((head_ + long_samples_ - 1 - back) % long_samples_)];
    for (std::size_t j = 0; j < kDirections; ++j) {
      cross[j] += cell.cross[j];
      square[j] += cell.square[j];
      if (square[j] <= 0.0) continue;
      const double score = cross[j] * cross[j] / square[j];
      if (score > best) {
        best = score;
        ago = back;
      }
    }
  }
  return ago;
}

}  // namespace faultlab::core
