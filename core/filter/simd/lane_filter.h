#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/filter/innovations.h"
#include "core/filter/simd/lane_model.h"
#include "core/numerics/rest_passage.h"

namespace faultlab::core {

/// Sums of log S for lanes whose motor passes through rest: there S never settles for long. A
/// logarithm is taken of the product of some S.
template <class Lane>
struct Passages {
  static constexpr int kTogether = 8;  // of S from 1e-38 to 1e38
  std::array<int, kOutputCount> readings{};
  std::array<bool, kLaneCount<Lane>> any{};
  std::array<std::array<double, kLaneCount<Lane>>, kOutputCount> log_s{};
  std::array<Lane, kOutputCount> product{Lane{} + 1.0, Lane{} + 1.0, Lane{} + 1.0};
  std::array<int, kOutputCount> factors{};

  /// A lane's first passage: its readings so far had the S at which it settled.
  void Begin(LaneMask<Lane> passes, const std::array<Lane, kOutputCount>& s, Lane no_news) {
    for (std::size_t lane = 0; lane < any.size(); ++lane) {
      if (!IsSet(passes, lane) || any[lane]) continue;
      any[lane] = true;
      for (std::size_t c = 0; c < kOutputCount; ++c) {
        const double count = readings[c] - (c == 0 ? GetLane(no_news, lane) : 0.0);
        log_s[c][lane] = count > 0.0 ? count * std::log(GetLane(s[c], lane)) : 0.0;
        SetLane(product[c], lane, 1.0);
      }
    }
  }

  double LogS(std::size_t c, std::size_t lane) const {
    return log_s[c][lane] + std::log(GetLane(product[c], lane));
  }

  [[gnu::always_inline]] void Add(std::size_t c, Lane s, LaneMask<Lane> used) {
    ++readings[c];
    product[c] = product[c] * (used ? s : Lane{} + 1.0);
    if (++factors[c] == kTogether) TakeLog(c);
  }

  [[gnu::noinline]] void TakeLog(std::size_t c) {
    for (std::size_t lane = 0; lane < any.size(); ++lane) {
      if (any[lane]) log_s[c][lane] += std::log(GetLane(product[c], lane));
    }
    product[c] = Lane{} + 1.0;
    factors[c] = 0;
  }
};

/// The Kalman filter behind RunInnovations, for one model or for several side by side. Each lane
/// gives the same bits as a run alone. kMcResponse: also computes the derivative of the innovations
/// by Mc. kSaturates: some model does; without it, no time is spent on that.
template <class Lane, bool kMcResponse, bool kSaturates>
class LaneFilter {
 public:
  using Whitened = std::array<Lane, kOutputCount>;

  /// `model` holds from the next step on; `uncharged`: with z = 0.
  void SetModel(std::size_t lane, const PredictionModel& model, bool uncharged) {
    model_.Set(lane, model);
    if (uncharged) SetLane(x_.z, lane, 0.0);
    holds_ = model.holds();
    SetLane(quiet_, lane, 0.0);
    held_ = false;
  }

  /// Stores the whitened innovations of the channels in now.mask (0 for a um that carries no
  /// information).
  [[gnu::always_inline]] void Step(const Observation& now, Whitened& z) {
    if (!held_ || now.restart || now.mask != mask_ || now.clipped != 0) {
      const bool starts = !started_ || now.restart;
      starts ? Start(now) : Advance(now);
      CorrectUnsettled(now, z, starts);
      return;
    }
    Advance(now);
    if (kSaturates && holds_ && !All(Not(passes_))) {
      CorrectUnsettled(now, z, false);
      return;
    }
    for (int channel = 0; channel < kOutputCount; ++channel) {
      if ((now.mask & (1U << channel)) == 0U) continue;
      const auto c = static_cast<std::size_t>(channel);
      const Lane by_mc = Reading(channel, model_, by_mc_);
      CorrectWith(channel, Innovation(channel, now), by_mc, now.trust[c], z);
      if (kSaturates && holds_) passages_.Add(c, s_[c], Lane{} == Lane{});
    }
  }

  /// The summary of one lane; `count_of`: number of readings of each channel.
  InnovationSummary Summary(std::size_t lane, const std::array<int, kOutputCount>& count_of) const {
    InnovationSummary sum;
    sum.count_of = count_of;
    sum.count_of[0] -= static_cast<int>(GetLane(no_news_, lane));
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      sum.chi2_of[c] = GetLane(chi2_[c], lane);
      sum.chi2 += sum.chi2_of[c];
      sum.count += sum.count_of[c];
      if (sum.count_of[c] == 0) continue;
      sum.log_det += kSaturates && passages_.any[lane]
                         ? passages_.LogS(c, lane)
                         : sum.count_of[c] * std::log(GetLane(UsualS(c), lane));
    }
    sum.mc_cross = GetLane(mc_cross_, lane);
    sum.mc_square = GetLane(mc_square_, lane);
    return sum;
  }

 private:
  using Mask = LaneMask<Lane>;

  // What the supply lets through.
  [[gnu::always_inline]] auto Limited(double u) const {
    if constexpr (kSaturates) {
      Lane through = Lane{} + u;
      through = through < model_.u_min ? model_.u_min : through;
      return model_.u_max < through ? model_.u_max : through;
    } else {
      return u;
    }
  }

  // Step of prediction_model.h, lane by lane. The friction term is added last: it has the longest
  // dependency chain.
  [[gnu::always_inline]] void Advance(const Observation& now) {
    if (kSaturates && holds_) {
      AdvanceHeld(now);
      return;
    }
    const LaneModel<Lane>& m = model_;
    const Lane one = Lane{} + 1.0;
    const auto u_prev = Limited(now.u_prev);
    const auto u = Limited(now.u);
    const LaneState<Lane> next = Carried(m, x_);
    Lane sign = x_.w * m.sign_per_speed;
    sign = sign < -one ? -one : sign;
    sign = one < sign ? one : sign;
    const Lane torque = sign * m.mc;
    x_.z = next.z + (m.z_prev * u_prev + m.z_now * u);
    x_.i = next.i + (m.i_prev * u_prev + m.i_now * u) + m.i_torque * torque;
    x_.w = next.w + (m.w_prev * u_prev + m.w_now * u) + m.w_torque * torque;
    x_.d = next.d;
    if constexpr (kMcResponse) {
      by_mc_ = Carried(m, by_mc_);
      by_mc_.i += m.i_torque * sign;
      by_mc_.w += m.w_torque * sign;
    }
  }

  // The same where friction holds the motor at rest and turns around with it.
  [[gnu::always_inline]] void AdvanceHeld(const Observation& now) {
    const LaneModel<Lane>& m = model_;
    const Lane zero{};
    const auto u_prev = Limited(now.u_prev);
    const auto u = Limited(now.u);
    const LaneState<Lane> next = Carried(m, LaneState<Lane>{x_.z, x_.i, x_.w, zero});
    const Lane i_friction = m.id * x_.d + m.i_torque * m.mc;
    const Lane w_friction = m.wd * x_.d + m.w_torque * m.mc;
    const Lane free = next.w + (m.w_prev * u_prev + m.w_now * u);
    const Lane edge_friction = m.edge_wd * x_.d + m.edge_w_torque * m.mc;
    const Lane edge_free =
        (m.edge_wz * x_.z + m.edge_wi * x_.i) + (m.edge_ww * x_.w + m.edge_wu * u_prev);
    ActFriction(x_.w,
                edge_free,
                free,
                edge_friction < zero ? -edge_friction : zero,
                w_friction < zero ? -w_friction : zero,
                m.edge_kept,
                m.later_kept,
                way_,
                passage_variance_);
    passage_variance_ = passage_variance_ * m.passage_variance;
    passes_ = passage_variance_ > zero;
    const Lane sign = way_;
    x_.z = next.z + (m.z_prev * u_prev + m.z_now * u);
    x_.i = next.i + (m.i_prev * u_prev + m.i_now * u) + sign * i_friction;
    x_.w = free + sign * w_friction;
    x_.d = m.dd * x_.d;
    if constexpr (kMcResponse) {
      const Lane by_torque = by_mc_.d;
      by_mc_ = Carried(m, LaneState<Lane>{by_mc_.z, by_mc_.i, by_mc_.w, zero});
      by_mc_.i += sign * (m.i_torque + m.id * by_torque);
      by_mc_.w += sign * (m.w_torque + m.wd * by_torque);
      by_mc_.d = m.dd * by_torque;
    }
  }

  [[gnu::always_inline]] Lane Innovation(int channel, const Observation& now) const {
    const auto c = static_cast<std::size_t>(channel);
    Lane y = model_.scales[c] * now.y[c] - model_.zeros[c];
    if (channel == 0) y = y - model_.um_u * Limited(now.u);
    return y - Reading(channel, model_, x_);
  }

  // The gain of d is that of a motor that turns forward: s = 1.
  [[gnu::always_inline]] Lane Forward(Lane gain) const {
    return kSaturates && holds_ ? way_ * gain : gain;
  }

  // Corrects the state by one reading with the present gain. `by_mc`: derivative of the predicted
  // reading by Mc.
  [[gnu::always_inline]] void CorrectWith(
      int channel, Lane e, Lane by_mc, double trust, Whitened& z) {
    const auto c = static_cast<std::size_t>(channel);
    const Lane weight = weight_[c] * trust;
    const LaneState<Lane>& gain = gain_[c];
    x_.z += gain.z * e;
    x_.i += gain.i * e;
    x_.w += gain.w * e;
    x_.d += Forward(gain.d) * e;
    z[c] = e * weight;
    chi2_[c] += z[c] * z[c];
    if constexpr (kMcResponse) {
      by_mc_.z -= gain.z * by_mc;
      by_mc_.i -= gain.i * by_mc;
      by_mc_.w -= gain.w * by_mc;
      by_mc_.d -= Forward(gain.d) * by_mc;
      const Lane whitened = by_mc * weight;
      mc_cross_ += z[c] * whitened;
      mc_square_ += whitened * whitened;
    }
  }

  // The gains count as settled when no S has moved by more than a small share for some samples;
  // what is lost by holding them is of second order in it.
  Mask Settled() const { return quiet_ >= model_.settled_samples; }

  // The corrections of a step while the covariance of some lane changes.
  [[gnu::noinline]] void CorrectUnsettled(const Observation& now, Whitened& z, bool starts) {
    const Lane zero{};
    const Mask none = zero < zero;
    if (!starts) {
      if (kSaturates && holds_) {
        passages_.Begin(passes_, {UsualS(0), UsualS(1), UsualS(2)}, no_news_);
        passed_ = passed_ | passes_;
        quiet_ = passed_ ? zero : quiet_;
      }
      p_.Replace(Not(Settled()), p_.Predicted(model_));
      if (kSaturates && holds_) p_.ww += passes_ ? passage_variance_ : zero;
    }
    Mask no_news = none;
    if (now.clipped != 0) {
      const double rail = now.clipped;
      const Lane predicted = Reading(0, model_, x_) + model_.um_u * Limited(now.u);
      const Lane reading = model_.scales[0] * now.y[0] - model_.zeros[0];
      no_news = predicted * rail >= zero + reading * rail;
      no_news_ += no_news ? zero + 1.0 : zero;
    }
    // The held gains are for other channels: the covariance recursion continues from its last
    // value, which is near enough.
    const Mask left = now.mask != mask_ ? Not(none) : no_news;
    const Mask restless = left & Settled();
    quiet_ = restless ? zero : quiet_;
    mask_ = now.mask;
    const Mask settled = Settled();
    Mask moved = none;
    for (int channel = 0; channel < kOutputCount; ++channel) {
      if ((now.mask & (1U << channel)) == 0U) continue;
      const Mask used = channel == 0 ? Not(no_news) : Not(none);
      moved = moved | FindGain(channel, used & Not(settled));
      const auto c = static_cast<std::size_t>(channel);
      const Lane e = Innovation(channel, now);
      const Lane by_mc = Reading(channel, model_, by_mc_);
      CorrectWith(channel, used ? e : zero, used ? by_mc : zero, now.trust[c], z);
      if (kSaturates && holds_) passages_.Add(c, s_[c], used);
    }
    if (now.mask != 0) {
      const Mask waits = settled | no_news | passed_;
      const Lane next = moved ? zero : quiet_ + 1.0;
      quiet_ = waits ? quiet_ : next;
    }
    after_gap_ = after_gap_ & Not(Settled());
    held_ = All(Settled());
  }

  // The S of nearly all readings so far. Just after a gap it is that from before.
  Lane UsualS(std::size_t c) const {
    const Mask before = after_gap_ & (Lane{} < s_before_gap_[c]) & (s_before_gap_[c] < s_[c]);
    return before ? s_before_gap_[c] : s_[c];
  }

  // Gain and S from the covariance, for the lanes in `mask`. Returns the lanes whose S has changed.
  Mask FindGain(int channel, Mask mask) {
    const auto c = static_cast<std::size_t>(channel);
    const LaneState<Lane> pc = p_.Times(channel, model_);
    const Lane s = Reading(channel, model_, pc) + model_.reading_variance[c];
    const Lane inverse = 1.0 / s;
    const LaneState<Lane> gain{pc.z * inverse, pc.i * inverse, pc.w * inverse, pc.d * inverse};
    p_.Replace(mask, p_.Corrected(gain, pc));
    gain_[c].z = mask ? gain.z : gain_[c].z;
    gain_[c].i = mask ? gain.i : gain_[c].i;
    gain_[c].w = mask ? gain.w : gain_[c].w;
    gain_[c].d = mask ? gain.d : gain_[c].d;
    weight_[c] = mask ? 1.0 / SquareRoot(s) : weight_[c];
    const Mask moved = mask & (Magnitude(s - s_[c]) > model_.settled_share * s);
    s_[c] = mask ? s : s_[c];
    return moved;
  }

  // The state is unknown. It starts at rest under the present input, so that the sign of friction
  // is right.
  void Start(const Observation& now) {
    const LaneModel<Lane>& m = model_;
    const Lane zero{};
    if (started_) {
      for (std::size_t c = 0; c < kOutputCount; ++c) s_before_gap_[c] = UsualS(c);
      after_gap_ = zero == zero;
    }
    const Lane one = zero + 1.0;
    const auto u = Limited(now.u);
    Lane mc = m.mc;
    if (kSaturates && holds_ && now.u < 0.0) mc = -mc;
    const Lane z = (m.z_prev + m.z_now) * u / (one - m.zz);
    const Lane b_i = m.iz * z + (m.i_prev + m.i_now) * u + m.i_torque * mc;
    const Lane b_w = m.wz * z + (m.w_prev + m.w_now) * u + m.w_torque * mc;
    const Lane determinant = (one - m.ii) * (one - m.ww) - m.iw * m.wi;
    Lane i = (b_i * (one - m.ww) + m.iw * b_w) / determinant;
    Lane w = (m.wi * b_i + (one - m.ii) * b_w) / determinant;
    if (kSaturates && holds_) {
      const Mask stands = now.u < 0.0 ? w > zero : w < zero;
      i = stands ? (b_i - m.i_torque * mc) / (one - m.ii) : i;
      w = stands ? zero : w;
    }
    const Lane largest = zero + std::numeric_limits<double>::max();
    const Mask finite =
        (Magnitude(z) <= largest) & (Magnitude(i) <= largest) & (Magnitude(w) <= largest);
    x_.z = finite ? z : zero;
    x_.i = finite ? i : zero;
    x_.w = finite ? w : zero;
    way_ = x_.w < zero ? -one : one;
    by_mc_ = LaneState<Lane>{};
    p_ = LaneCovariance<Lane>{};
    p_.zz = m.start_z;
    p_.ii = m.start_i;
    p_.ww = m.start_w;
    p_.dd = m.torque_variance;
    quiet_ = zero;
    passes_ = zero < zero;
    started_ = true;
  }

  LaneModel<Lane> model_{};
  LaneState<Lane> x_{};
  LaneState<Lane> by_mc_{};  // dx/dMc
  Lane way_{};               // where friction holds the motor: s of the last step
  std::array<LaneState<Lane>, kOutputCount> gain_{};
  std::array<Lane, kOutputCount> weight_{};  // 1 / sqrt(S)
  std::array<Lane, kOutputCount> chi2_{};
  Lane mc_cross_{};
  Lane mc_square_{};
  Mask passes_{};  // through rest, in the last step
  Mask passed_{};  // in any; then gains never settle, so that sums stay smooth
  Lane passage_variance_{};
  bool holds_ = false;  // friction holds the motor at rest
  bool held_ = false;   // all lanes are settled, with the channels of mask_
  bool started_ = false;
  unsigned mask_ = 0;
  // Used only while the covariance changes.
  std::array<Lane, kOutputCount> s_{};
  std::array<Lane, kOutputCount> s_before_gap_{};
  Mask after_gap_{};  // not settled since the last gap
  LaneCovariance<Lane> p_{};
  Lane quiet_{};    // samples since an S last changed
  Lane no_news_{};  // readings of um that were only bounds
  Passages<Lane> passages_;
};

}  // namespace faultlab::core
