#include "core/diagnosis/innovation_filter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// What is known of a state before the first reading: less than any drive can reach.
constexpr double kPoleSdV = 10.0;
constexpr double kCurrentSdA = 2.0;
constexpr double kSpeedSdRadS = 500.0;
// The gains count as settled when no S has moved by more than this share for some samples; what is
// lost by holding them is of second order in it.
constexpr double kSettledShare = 2e-4;
constexpr int kSettledSamples = 6;

// A state that explains the first sample, so that the friction's sign starts right.
Eigen::Vector4d FirstGuess(const PredictionModel& model, const Observation& first) {
  // Rest under the present input.
  Eigen::Matrix4d a = Eigen::Matrix4d::Identity() - model.phi;
  const Eigen::Vector4d b = (model.g_prev + model.g) * first.u - model.g_torque * model.mc_nm;
  Eigen::Vector4d x = a.partialPivLu().solve(b);
  if (!x.allFinite()) x.setZero();
  return x;
}

// x+ = phi x + g_prev u_prev + g u + g_torque s Mc. Plain loops: this is where a fit spends its
// time, and they cost half of the same expression in Eigen.
inline void Advance(const PredictionModel& model,
                    const Observation& now,
                    double sign,
                    Eigen::Vector4d& x) {
  const double* phi = model.phi.data();
  const double* g_prev = model.g_prev.data();
  const double* g = model.g.data();
  const double* g_torque = model.g_torque.data();
  const double torque = sign * model.mc_nm;
  std::array<double, 4> next;
  for (std::size_t i = 0; i < 4; ++i) {
    next[i] = phi[i] * x(0) + phi[4 + i] * x(1) + phi[8 + i] * x(2) + phi[12 + i] * x(3) +
              g_prev[i] * now.u_prev + g[i] * now.u + g_torque[i] * torque;
  }
  x = Eigen::Vector4d::Map(next.data());
}

}  // namespace

void GainRecursion::Restart() {
  p_ = Eigen::Vector4d(kPoleSdV * kPoleSdV,
                       kCurrentSdA * kCurrentSdA,
                       kSpeedSdRadS * kSpeedSdRadS,
                       model_->torque_variance)
           .asDiagonal();
}

// P+ = phi P phi' + Q, kept symmetric.
void GainRecursion::Predict() {
  const Eigen::Matrix4d left = model_->phi * p_;
  p_.noalias() = left * model_->phi.transpose();
  p_(3, 3) += model_->torque_step_variance;
  const Eigen::Matrix4d symmetric = 0.5 * (p_ + p_.transpose());
  p_ = symmetric;
}

double GainRecursion::Correct(int channel, Eigen::Vector4d& gain) {
  const Eigen::Vector4d ph = p_ * model_->c.row(channel).transpose();
  const double s =
      model_->c.row(channel).dot(ph) + model_->reading_variance[static_cast<std::size_t>(channel)];
  gain = ph / s;
  p_.noalias() -= gain * ph.transpose();
  return s;
}

InnovationSummary RunInnovations(const PredictionModel& model,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace) {
  const ModelSegment only{0, &model};
  return RunInnovations(std::span<const ModelSegment>(&only, 1), stretch, trace);
}

InnovationSummary RunInnovations(std::span<const ModelSegment> segments,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace) {
  LAB_CHECK(!segments.empty() && segments.front().from == 0);
  const PredictionModel* current = segments.front().model;
  std::size_t next_segment = 1;
  InnovationSummary sum;
  const bool with_mc = trace == nullptr;
  if (trace != nullptr) {
    trace->whitened.assign(stretch.size() * kOutputCount, 0.0);
  }
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  Eigen::Vector4d xm = Eigen::Vector4d::Zero();  // dx/dMc
  GainRecursion recursion(*current);
  std::array<Eigen::Vector4d, kOutputCount> gain;
  std::array<double, kOutputCount> s{};
  std::array<double, kOutputCount> last_s{};
  std::array<double, kOutputCount> weight{};
  int quiet = 0;
  bool settled = false;
  unsigned settled_mask = 0;

  for (std::size_t k = 0; k < stretch.size(); ++k) {
    const Observation& now = stretch[k];
    if (next_segment < segments.size() && segments[next_segment].from == k) {
      current = segments[next_segment].model;
      if (segments[next_segment].uncharged) x(0) = 0.0;
      ++next_segment;
      recursion.SetModel(*current);
      settled = false;
      quiet = 0;
    }
    const PredictionModel& model = *current;
    if (k == 0 || now.restart) {
      const double friction = k == 0 ? 0.0 : x(3);
      x = FirstGuess(model, now);
      x(3) = friction;
      xm.setZero();
      recursion.Restart();
      settled = false;
      quiet = 0;
    } else {
      const double sign = std::clamp(x(2) / kCreepSpeed, -1.0, 1.0);
      Advance(model, now, sign, x);
      if (with_mc) {
        const Eigen::Vector4d next_m = model.phi * xm + model.g_torque * sign;
        xm = next_m;
      }
      if (!settled) recursion.Predict();
    }
    unsigned use = now.mask;
    if (now.clipped != 0) {
      const double predicted = model.c.row(0).dot(x) + model.d(0) * now.u;
      if (predicted * now.clipped >= now.y[0] * now.clipped) use &= ~1U;
    }
    if (settled && use != settled_mask) {
      // Other channels than the held gains are for: take the covariance up again, near enough
      // where it was left.
      settled = false;
      quiet = 0;
    }
    bool moved = false;
    for (int channel = 0; channel < kOutputCount; ++channel) {
      if ((use & (1U << channel)) == 0U) continue;
      const auto c = static_cast<std::size_t>(channel);
      if (!settled) {
        s[c] = recursion.Correct(channel, gain[c]);
        weight[c] = 1.0 / std::sqrt(s[c]);
        moved = moved || std::abs(s[c] - last_s[c]) > kSettledShare * s[c];
        last_s[c] = s[c];
      }
      const double e = now.y[c] - model.c.row(channel).dot(x) - model.d(channel) * now.u;
      x += gain[c] * e;
      const double z = e * weight[c];
      sum.chi2 += z * z;
      sum.chi2_of[c] += z * z;
      ++sum.count_of[c];
      if (with_mc) {
        const double em = model.c.row(channel).dot(xm);
        xm -= gain[c] * em;
        const double zm = em * weight[c];
        sum.mc_cross += z * zm;
        sum.mc_square += zm * zm;
      }
      if (trace != nullptr) {
        trace->whitened[k * kOutputCount + c] = z;
      }
    }
    if (!settled) {
      quiet = moved ? 0 : quiet + 1;
      if (quiet >= kSettledSamples && use == now.mask && use != 0U) {
        settled = true;
        settled_mask = use;
        // The next gap in the channels starts from the predicted covariance of this point.
      }
    }
  }
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    sum.count += sum.count_of[c];
    if (sum.count_of[c] > 0) sum.log_det += sum.count_of[c] * std::log(s[c]);
  }
  return sum;
}

ChannelGains Settle(const PredictionModel& model, unsigned mask) {
  ChannelGains settled;
  GainRecursion recursion(model);
  recursion.Restart();
  constexpr int kSteps = 2000;  // 20 s: many times every time constant of the rig
  for (int k = 0; k < kSteps; ++k) {
    recursion.Predict();
    for (int channel = 0; channel < kOutputCount; ++channel) {
      const auto c = static_cast<std::size_t>(channel);
      settled.gain[c].setZero();
      if ((mask & (1U << channel)) == 0U) continue;
      settled.inverse_sd[c] = 1.0 / std::sqrt(recursion.Correct(channel, settled.gain[c]));
    }
  }
  return settled;
}

}  // namespace faultlab::core
