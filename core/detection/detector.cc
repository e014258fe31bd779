#include "core/detection/detector.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/filter/impulses.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// The component of a bench that acts only when it is large: the capacitor of its amplifier.
const ComponentInfo* CapacitorOf(const Bench& bench) {
  const auto found = std::find_if(bench.parts.begin(), bench.parts.end(), [](const auto& part) {
    return part.kind == PartKind::kCapacitor;
  });
  return found != bench.parts.end() ? &*found : nullptr;
}

constexpr int kRaDirection = 3;
constexpr double kRaShare = 0.9;

// The finite changes whose responses are the directions: about the smallest fault of interest of
// each component. Near its nominal value a capacitor has no effect, so its direction is the secant
// to the smallest visible value. Large changes of Ra and J have other responses than small ones, so
// they have secants of their own.
RigParameters Changed(const Bench& bench, const RigParameters& reference, int direction) {
  RigParameters changed = reference;
  PlantParameters& plant = changed.plant;
  const ComponentInfo* capacitor = CapacitorOf(bench);
  switch (direction) {
    case 0:
      changed.gain_factor *= 0.98;
      break;
    case 1:
      plant.series_ohm *= 2.0;
      break;
    case 2:
      if (capacitor != nullptr) {
        plant.Set(capacitor->parameter, plant.Get(capacitor->parameter) + capacitor->least_visible);
      } else {
        plant.ke_v_per_rad_s *= 0.95;
      }
      break;
    case 3:
      plant.ra_ohm *= kRaShare;
      break;
    case 4:
      plant.j_kg_m2 *= 1.1;
      break;
    case 5:
      plant.b_nm_per_rad_s *= 3.0;
      break;
    case 6:
      plant.ra_ohm *= 0.15;
      break;
    case 7:
      plant.j_kg_m2 *= 10.0;
      break;
    default:
      changed.mc_nm += changed.mc_unit_nm;
      break;
  }
  return changed;
}

// After a start or a gap the gains are computed step by step for three times the slowest time
// constant, which is that of the slow friction torque.
constexpr double kFindingTimeConstants = 3.0;
// Log likelihood ratio of one innovation between variance 4 and variance 1. Smaller changes are
// left to the GLRs, which know the shape of the response.
constexpr double kCusumSlope = 0.5 * (1.0 - 1.0 / 4.0);
constexpr double kCusumCost = std::numbers::ln2;
// If |z| of the sample that raises the alarm exceeds this, that sample is itself faulty.
constexpr double kSharp = 5.0;

// Log likelihood ratios of a sample with a reading that is far off, and of one without: such
// samples are one in a hundred on a healthy rig with impulses, and more than every other one after
// a fault that is seen at once. Four in a row pass the level.
constexpr double kOddGain = 4.6;
constexpr double kOddCost = 1.5;
constexpr double kOddLevel = 17.0;
constexpr int kOddSamples = 4;
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
    : speed_step_s_(speed_step_s),
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
      error_(error),
      walk_(error.ra_walk / -std::log(kRaShare)) {
  models_[0].model = MakePredictionModel(reference, noise, period_s);
  for (int j = 0; j < kDirections; ++j) {
    models_[static_cast<std::size_t>(j + 1)].model =
        MakePredictionModel(Changed(bench, reference, j), noise, period_s);
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
  odd_ = 0.0;
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

void Detector::AfterStep(std::size_t age, ChannelGains& gains) const {
  // The state goes on believing them: what is left after a step is mostly of the state.
  for (std::size_t c = 0; c < kOutputCount; ++c) gains.inverse_sd[c] /= error_.growth[c][age];
}

void Detector::Whiten(const Observation& o,
                      const ChannelGains& gains,
                      std::array<std::array<double, kOutputCount>, kDirections + 1>& z,
                      unsigned use) {
  for (std::size_t i = 0; i < models_.size(); ++i) {
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
      z[i][c] = e * gains.inverse_sd[c];
    };
    // um is made of two states and the input; the other readings are states.
    if ((use & 1U) != 0U) correct(0, o.y[0] - (m.c(0, 0) * x(0) + m.c(0, 1) * x(1)) - m.d(0) * u);
    if ((use & 2U) != 0U) correct(1, o.y[1] - x(1));
    if ((use & 4U) != 0U) correct(2, o.y[2] - x(2));
  }
}

unsigned Detector::FarOff(const Observation& o, const ChannelGains& gains, unsigned use) const {
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
    if (std::abs(e) * gains.inverse_sd[c] * noise_scale_.Weight(c) > kImpulseGate) far |= 1U << c;
  }
  return far;
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
  std::array<std::array<double, kOutputCount>, kDirections + 1> z;
  const bool coarse = speed_step_s_ > 0.0 && (use & 4U) != 0U;
  ChannelGains gains = Gains(use, PassageVariance(o));
  if (error_.step_v > 0.0) AfterStep(age_.Push(o, error_.step_v), gains);
  if (impulses_) {
    const unsigned far = FarOff(o, gains, use);
    use &= ~far;
    odd_ = std::max(0.0, odd_ + (far != 0U ? kOddGain : -kOddCost));
  }
  if (coarse) gains = WithRounding(gains, o.y[2]);
  Whiten(o, gains, z, use);
  whitened_ = z[0];
  inverse_sd_ = gains.inverse_sd;

  double largest = 0.0;
  double step = 0.0;
  Cell cell;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if ((use & (1U << c)) == 0U) continue;
    const double weight = noise_scale_.Weight(c);
    const double r = z[0][c] * weight;
    noise_scale_.Push(c, z[0][c]);
    const double ra = r - z[kRaDirection + 1][c] * weight;
    const double alone = walk_ > 0.0 ? r / std::hypot(1.0, walk_ * ra) : r;
    largest = std::max(largest, std::abs(alone));
    step += kCusumSlope * alone * alone - kCusumCost;
    if (lost_ > 0) continue;
    for (std::size_t j = 0; j < kDirections; ++j) {
      const double s = r - z[j + 1][c] * weight;
      cell.cross[j] += static_cast<float>(s * r);
      cell.square[j] += static_cast<float>(s * s);
      if (walk_ > 0.0) cell.with_ra[j] += static_cast<float>(s * ra);
    }
  }
  lost_ = std::max(0, lost_ - 1);
  cusum_ = std::max(0.0, cusum_ + step);
  cusum_age_ = cusum_ > 0.0 ? cusum_age_ + 1 : 0;

  Cell& oldest = ring_[static_cast<std::size_t>(head_)];
  int leaving_at = head_ - short_samples_;
  if (leaving_at < 0) leaving_at += long_samples_;
  const Cell& leaving_short = ring_[static_cast<std::size_t>(leaving_at)];
  for (std::size_t j = 0; j < kDirections; ++j) {
    long_cross_[j] += static_cast<double>(cell.cross[j]) - oldest.cross[j];
    long_square_[j] += static_cast<double>(cell.square[j]) - oldest.square[j];
    short_cross_[j] += static_cast<double>(cell.cross[j]) - leaving_short.cross[j];
    short_square_[j] += static_cast<double>(cell.square[j]) - leaving_short.square[j];
    slow_cross_[j] = forget_ * slow_cross_[j] + static_cast<double>(cell.cross[j]);
    slow_square_[j] = forget_ * forget_ * slow_square_[j] + static_cast<double>(cell.square[j]);
    if (walk_ == 0.0) continue;
    long_with_ra_[j] += static_cast<double>(cell.with_ra[j]) - oldest.with_ra[j];
    short_with_ra_[j] += static_cast<double>(cell.with_ra[j]) - leaving_short.with_ra[j];
    slow_with_ra_[j] = forget_ * slow_with_ra_[j] + static_cast<double>(cell.with_ra[j]);
  }
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
    const std::array<double, 3> of = {Glr(short_cross_[j], short_square_[j], short_with_ra_[j]),
                                      Glr(long_cross_[j], long_square_[j], long_with_ra_[j]),
                                      Glr(slow_cross_[j], slow_square_[j], slow_with_ra_[j])};
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
  statistics_ = {largest, cusum, glr_short, glr_long, glr_slow, odd_ / kOddLevel};

  Alarm alarm;
  if (odd_ > kOddLevel) {
    alarm = {"residual", odd_, kOddLevel, 0, true};
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
  alarm.samples_ago = odd_ > kOddLevel ? kOddSamples - 1 : OnsetSamplesAgo();
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

int Detector::DirectionOf(const Bench& bench, Coordinate coordinate) {
  switch (coordinate) {
    case Coordinate::kGain:
      return 0;
    case Coordinate::kSeries:
      return 1;
    case Coordinate::kKe:
      return CapacitorOf(bench) == nullptr ? 2 : -1;
    case Coordinate::kRa:
      return kRaDirection;
    case Coordinate::kJ:
      return 4;
    case Coordinate::kB:
      return 5;
    default:
      return -1;
  }
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
