#include "core/detection/detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace faultlab::core {
namespace {

// Finite changes whose responses are the directions: about the smallest fault of each component
// that matters. C8 has no slope at 47 pF, so its direction is the secant to 1 uF; large changes of
// Ra and J look too little like small ones, so they have secants of their own.
RigParameters Changed(const RigParameters& reference, int direction) {
  RigParameters changed = reference;
  switch (direction) {
    case 0:
      changed.gain_factor *= 0.98;
      break;
    case 1:
      changed.plant.r1_ohm *= 2.0;
      break;
    case 2:
      changed.plant.c8_farad += 1e-6;
      break;
    case 3:
      changed.plant.ra_ohm *= 0.9;
      break;
    case 4:
      changed.plant.j_kg_m2 *= 1.1;
      break;
    case 5:
      changed.plant.b_nm_per_rad_s *= 3.0;
      break;
    case 6:
      changed.plant.ra_ohm *= 0.15;
      break;
    case 7:
      changed.plant.j_kg_m2 *= 10.0;
      break;
    default:
      changed.mc_nm += 1e-4;
      break;
  }
  return changed;
}

// Samples for which the gains are computed step by step after a start or a gap: three times the
// slowest settling, that of the friction's deviation.
constexpr int kFindingSamples = 150;
// log likelihood ratio of one innovation between variance 4 and variance 1. What changes the
// variance by less is left to the GLRs, which know its shape.
constexpr double kCusumSlope = 0.5 * (1.0 - 1.0 / 4.0);
constexpr double kCusumCost = std::numbers::ln2;
constexpr double kForget = 1.0 - 1.0 / Detector::kSlow;
// A |z| beyond this in the alarm's own sample means that the sample is faulty by itself.
constexpr double kSharp = 5.0;

}  // namespace

Detector::Detector(const RigParameters& reference,
                   const NoiseLevel& noise,
                   double period_s,
                   unsigned mask,
                   const DetectionThresholds& thresholds,
                   int reference_samples,
                   const NoiseScale& noise_scale)
    : recursion_(models_[0].model),
      thresholds_(thresholds),
      noise_scale_(noise_scale),
      ring_(kLong) {
  models_[0].model = MakePredictionModel(reference, noise, period_s);
  for (int j = 0; j < kDirections; ++j) {
    models_[static_cast<std::size_t>(j + 1)].model =
        MakePredictionModel(Changed(reference, j), noise, period_s);
  }
  settled_ = SteadyStateGains(models_[0].model, mask);
  reference_samples_ = std::max(50, reference_samples);
  inflation_short_ = 1.0 + kShort / reference_samples_;
  inflation_long_ = 1.0 + kLong / reference_samples_;
}

void Detector::Restart(const Observation& observation) {
  for (Model& m : models_) {
    const Eigen::Matrix4d a = Eigen::Matrix4d::Identity() - m.model.phi;
    const Eigen::Vector4d b =
        (m.model.g_prev + m.model.g) * observation.u + m.model.g_torque * m.model.mc_nm;
    m.x = a.partialPivLu().solve(b);
    if (!m.x.allFinite()) m.x.setZero();
  }
  recursion_.Restart();
  finding_samples_ = kFindingSamples;
  cusum_ = 0.0;
  cusum_age_ = 0;
  std::fill(ring_.begin(), ring_.end(), Cell{});
  filled_ = 0;
  short_cross_.fill(0.0);
  short_square_.fill(0.0);
  long_cross_.fill(0.0);
  long_square_.fill(0.0);
  slow_cross_.fill(0.0);
  slow_square_.fill(0.0);
  slow_weight_ = 0.0;
  slow_weight_square_ = 0.0;
}

const ChannelGains& Detector::Gains(unsigned use) {
  if (finding_samples_ == 0) return settled_;
  if (finding_samples_ < kFindingSamples) recursion_.Predict();
  --finding_samples_;
  for (int channel = 0; channel < kOutputCount; ++channel) {
    const auto c = static_cast<std::size_t>(channel);
    if ((use & (1U << channel)) == 0U) continue;
    finding_.inverse_sd[c] = 1.0 / std::sqrt(recursion_.Correct(channel, finding_.gain[c]));
  }
  return finding_;
}

void Detector::Whiten(const Observation& o,
                      const ChannelGains& gains,
                      std::array<std::array<double, kOutputCount>, kDirections + 1>& z,
                      unsigned use) {
  for (std::size_t i = 0; i < models_.size(); ++i) {
    Model& m = models_[i];
    if (!o.restart) {
      const Eigen::Vector4d next = Step(m.model, m.x, o.u_prev, o.u);
      m.x = next;
    }
    for (int channel = 0; channel < kOutputCount; ++channel) {
      const auto c = static_cast<std::size_t>(channel);
      z[i][c] = 0.0;
      if ((use & (1U << channel)) == 0U) continue;
      const double e = o.y[c] - m.model.c.row(channel).dot(m.x) - m.model.d(channel) * o.u;
      m.x += gains.gain[c] * e;
      z[i][c] = e * gains.inverse_sd[c];
    }
  }
}

std::optional<Alarm> Detector::Push(const Observation& o) {
  if (o.restart) Restart(o);
  unsigned use = o.mask;
  if (o.clipped != 0) {
    const PredictionModel& m = models_[0].model;
    const Eigen::Vector4d next = Step(m, models_[0].x, o.u_prev, o.u);
    const double predicted = m.c.row(0).dot(next) + m.d(0) * o.u;
    // At the rail a reading is a bound: no news when the prediction lies beyond it.
    if (predicted * o.clipped >= o.y[0] * o.clipped) use &= ~1U;
  }
  std::array<std::array<double, kOutputCount>, kDirections + 1> z;
  Whiten(o, Gains(use), z, use);

  double largest = 0.0;
  double step = 0.0;
  Cell cell;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if ((use & (1U << c)) == 0U) continue;
    const double weight = noise_scale_.Weight(c);
    const double r = z[0][c] * weight;
    noise_scale_.Push(c, z[0][c]);
    largest = std::max(largest, std::abs(r));
    step += kCusumSlope * r * r - kCusumCost;
    for (std::size_t j = 0; j < kDirections; ++j) {
      const double s = r - z[j + 1][c] * weight;
      cell.cross[j] += static_cast<float>(s * r);
      cell.square[j] += static_cast<float>(s * s);
    }
  }
  cusum_ = std::max(0.0, cusum_ + step);
  cusum_age_ = cusum_ > 0.0 ? cusum_age_ + 1 : 0;

  Cell& oldest = ring_[static_cast<std::size_t>(head_)];
  const Cell& leaving_short = ring_[static_cast<std::size_t>((head_ + kLong - kShort) % kLong)];
  for (std::size_t j = 0; j < kDirections; ++j) {
    long_cross_[j] += static_cast<double>(cell.cross[j]) - oldest.cross[j];
    long_square_[j] += static_cast<double>(cell.square[j]) - oldest.square[j];
    short_cross_[j] += static_cast<double>(cell.cross[j]) - leaving_short.cross[j];
    short_square_[j] += static_cast<double>(cell.square[j]) - leaving_short.square[j];
    slow_cross_[j] = kForget * slow_cross_[j] + static_cast<double>(cell.cross[j]);
    slow_square_[j] = kForget * kForget * slow_square_[j] + static_cast<double>(cell.square[j]);
  }
  slow_weight_ = kForget * slow_weight_ + 1.0;
  slow_weight_square_ = kForget * kForget * slow_weight_square_ + 1.0;
  oldest = cell;
  head_ = (head_ + 1) % kLong;
  filled_ = std::min(filled_ + 1, kLong);

  double glr_short = 0.0;
  double glr_long = 0.0;
  double glr_slow = 0.0;
  for (std::size_t j = 0; j < kDirections; ++j) {
    if (short_square_[j] > 0.0) {
      glr_short = std::max(glr_short, short_cross_[j] * short_cross_[j] / short_square_[j]);
    }
    if (long_square_[j] > 0.0) {
      glr_long = std::max(glr_long, long_cross_[j] * long_cross_[j] / long_square_[j]);
    }
    if (slow_square_[j] > 0.0) {
      glr_slow = std::max(glr_slow, slow_cross_[j] * slow_cross_[j] / slow_square_[j]);
    }
  }
  const double inflation = noise_scale_.threshold_inflation();
  largest /= std::sqrt(inflation);
  glr_short /= inflation_short_ * inflation;
  glr_long /= inflation_long_ * inflation;
  glr_slow /=
      (1.0 + slow_weight_ * slow_weight_ / (slow_weight_square_ * reference_samples_)) * inflation;
  const double cusum = cusum_ / inflation;
  statistics_ = {largest, cusum, glr_short, glr_long, glr_slow};

  Alarm alarm;
  if (largest > thresholds_.residual) {
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
  alarm.samples_ago = OnsetSamplesAgo();
  if (alarm.detector[0] == 'c') alarm.samples_ago = std::max(alarm.samples_ago, cusum_age_ - 1);
  return alarm;
}

int Detector::OnsetSamplesAgo() const {
  // The start k that makes (sum from k of s z)^2 / (sum of s^2) largest, over directions.
  std::array<double, kDirections> cross{};
  std::array<double, kDirections> square{};
  double best = 0.0;
  int ago = 0;
  for (int back = 0; back < filled_; ++back) {
    const Cell& cell = ring_[static_cast<std::size_t>((head_ + kLong - 1 - back) % kLong)];
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
