#pragma once

#include <array>
#include <cstddef>

#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"
#include "core/numerics/lanes.h"

namespace faultlab::core {

// A Lane is a double, or several side by side (lanes.h). A comparison of lanes gives their mask,
// and `mask ? a : b` chooses lane by lane.
template <class Lane>
inline constexpr std::size_t kLaneCount = sizeof(Lane) / sizeof(double);
template <class Lane>
using LaneMask = decltype(Lane{} < Lane{});

[[gnu::always_inline]] inline void SetLane(double& to, std::size_t, double value) {
  to = value;
}
template <class Lane>
[[gnu::always_inline]] inline void SetLane(Lane& to, std::size_t lane, double value) {
  to[lane] = value;
}
[[gnu::always_inline]] inline double GetLane(double from, std::size_t) {
  return from;
}
template <class Lane>
[[gnu::always_inline]] inline double GetLane(Lane from, std::size_t lane) {
  return from[lane];
}
[[gnu::always_inline]] inline bool Not(bool mask) {
  return !mask;
}
template <class Mask>
requires(sizeof(Mask) > sizeof(double)) [[gnu::always_inline]] inline Mask Not(Mask mask) {
  return ~mask;
}
[[gnu::always_inline]] inline bool All(bool mask) {
  return mask;
}
template <class Mask>
requires(sizeof(Mask) > sizeof(double)) [[gnu::always_inline]] inline bool All(Mask mask) {
  bool all = true;
  for (std::size_t lane = 0; lane < sizeof(Mask) / sizeof(double); ++lane) {
    all = all && mask[lane] != 0;
  }
  return all;
}

[[gnu::always_inline]] inline bool IsSet(bool mask, std::size_t) {
  return mask;
}
template <class Mask>
requires(sizeof(Mask) > sizeof(double))
    [[gnu::always_inline]] inline bool IsSet(Mask mask, std::size_t lane) {
  return mask[lane] != 0;
}

/// A filter's gains count as settled when no S has moved by more than this share for so many
/// samples, at 100 Hz and below. Faster samples move it less each, and the friction's deviation,
/// which is slow, is found last: there it takes as long.
inline constexpr double kSettledShare = 2e-4;
inline constexpr double kSettledSamples = 6.0;

/// Prediction models side by side, without their zeros: C8's pole z and the friction's deviation d
/// move by themselves, current i and speed w by everything.
template <class Lane>
struct LaneModel {
  Lane zz, iz, ii, iw, id, wz, wi, ww, wd, dd;  ///< phi; first letter: row, second letter: column
  Lane z_prev, i_prev, w_prev;                  ///< g_prev
  Lane z_now, i_now, w_now;                     ///< g
  Lane i_torque, w_torque, mc;
  Lane edge_kept, later_kept;  ///< shares of the speed that are left, before and after the edge
  Lane edge_wz, edge_wi, edge_ww, edge_wd, edge_wu, edge_w_torque;  ///< the speed at the edge of u
  Lane um_z, um_i, um_u;  ///< um = um_z z + um_i i + um_u u; the other readings are states
  Lane step_variance, torque_variance, passage_variance;
  std::array<Lane, kOutputCount> reading_variance;
  std::array<Lane, kOutputCount> zeros, scales;  ///< of readings
  Lane sign_per_speed;  ///< without friction that holds the motor: s = w times this, within +-1
  Lane u_min, u_max;
  Lane start_z, start_i, start_w;  ///< variances before the first reading
  Lane settled_share, settled_samples;

  void Set(std::size_t lane, const PredictionModel& m) {
    SetLane(zz, lane, m.phi(0, 0));
    SetLane(iz, lane, m.phi(1, 0));
    SetLane(ii, lane, m.phi(1, 1));
    SetLane(iw, lane, m.phi(1, 2));
    SetLane(id, lane, m.phi(1, 3));
    SetLane(wz, lane, m.phi(2, 0));
    SetLane(wi, lane, m.phi(2, 1));
    SetLane(ww, lane, m.phi(2, 2));
    SetLane(wd, lane, m.phi(2, 3));
    SetLane(dd, lane, m.phi(3, 3));
    SetLane(z_prev, lane, m.g_prev(0));
    SetLane(i_prev, lane, m.g_prev(1));
    SetLane(w_prev, lane, m.g_prev(2));
    SetLane(z_now, lane, m.g(0));
    SetLane(i_now, lane, m.g(1));
    SetLane(w_now, lane, m.g(2));
    SetLane(i_torque, lane, m.g_torque(1));
    SetLane(w_torque, lane, m.g_torque(2));
    SetLane(mc, lane, m.mc_nm);
    SetLane(edge_kept, lane, m.edge_kept);
    SetLane(later_kept, lane, m.later_kept);
    SetLane(edge_wz, lane, m.edge_w(0));
    SetLane(edge_wi, lane, m.edge_w(1));
    SetLane(edge_ww, lane, m.edge_w(2));
    SetLane(edge_wd, lane, m.edge_w(3));
    SetLane(edge_wu, lane, m.edge_w_u);
    SetLane(edge_w_torque, lane, m.edge_w_torque);
    SetLane(um_z, lane, m.c(0, 0));
    SetLane(um_i, lane, m.c(0, 1));
    SetLane(um_u, lane, m.d(0));
    SetLane(step_variance, lane, m.torque_step_variance);
    SetLane(torque_variance, lane, m.torque_variance);
    SetLane(passage_variance, lane, m.passage_variance);
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      SetLane(reading_variance[c], lane, m.reading_variance[c]);
      SetLane(zeros[c], lane, m.zeros[c]);
      SetLane(scales[c], lane, m.scales[c]);
    }
    SetLane(sign_per_speed, lane, m.holds() ? 0.0 : 1.0 / m.creep_rad_s);
    SetLane(u_min, lane, m.u_min);
    SetLane(u_max, lane, m.u_max);
    SetLane(start_z, lane, m.start_sd(0) * m.start_sd(0));
    SetLane(start_i, lane, m.start_sd(1) * m.start_sd(1));
    SetLane(start_w, lane, m.start_sd(2) * m.start_sd(2));
    SetLane(settled_share, lane, kSettledShare / m.density);
    SetLane(settled_samples, lane, kSettledSamples * m.density);
  }
};

template <class Lane>
struct LaneState {
  Lane z, i, w, d;
};

/// Upper triangle of the state's covariance.
template <class Lane>
struct LaneCovariance {
  Lane zz, zi, zw, zd, ii, iw, id, ww, wd, dd;

  /// phi P phi' + Q
  LaneCovariance Predicted(const LaneModel<Lane>& m) const {
    // Rows i and w of phi P.
    const LaneState<Lane> i{m.iz * zz + m.ii * zi + m.iw * zw + m.id * zd,
                            m.iz * zi + m.ii * ii + m.iw * iw + m.id * id,
                            m.iz * zw + m.ii * iw + m.iw * ww + m.id * wd,
                            m.iz * zd + m.ii * id + m.iw * wd + m.id * dd};
    const LaneState<Lane> w{m.wz * zz + m.wi * zi + m.ww * zw + m.wd * zd,
                            m.wz * zi + m.wi * ii + m.ww * iw + m.wd * id,
                            m.wz * zw + m.wi * iw + m.ww * ww + m.wd * wd,
                            m.wz * zd + m.wi * id + m.ww * wd + m.wd * dd};
    LaneCovariance next;
    next.zz = m.zz * m.zz * zz;
    next.zi = m.zz * i.z;
    next.zw = m.zz * w.z;
    next.zd = m.zz * m.dd * zd;
    next.ii = m.iz * i.z + m.ii * i.i + m.iw * i.w + m.id * i.d;
    next.iw = m.wz * i.z + m.wi * i.i + m.ww * i.w + m.wd * i.d;
    next.id = m.dd * i.d;
    next.ww = m.wz * w.z + m.wi * w.i + m.ww * w.w + m.wd * w.d;
    next.wd = m.dd * w.d;
    next.dd = m.dd * m.dd * dd + m.step_variance;
    return next;
  }

  /// P c for the row c of a channel's reading.
  LaneState<Lane> Times(int channel, const LaneModel<Lane>& m) const {
    switch (channel) {
      case 0:
        return {m.um_z * zz + m.um_i * zi,
                m.um_z * zi + m.um_i * ii,
                m.um_z * zw + m.um_i * iw,
                m.um_z * zd + m.um_i * id};
      case 1:
        return {zi, ii, iw, id};
      default:
        return {zw, iw, ww, wd};
    }
  }

  /// P - gain (P c)'
  LaneCovariance Corrected(const LaneState<Lane>& gain, const LaneState<Lane>& pc) const {
    return {zz - gain.z * pc.z,
            zi - gain.z * pc.i,
            zw - gain.z * pc.w,
            zd - gain.z * pc.d,
            ii - gain.i * pc.i,
            iw - gain.i * pc.w,
            id - gain.i * pc.d,
            ww - gain.w * pc.w,
            wd - gain.w * pc.d,
            dd - gain.d * pc.d};
  }

  /// `next` where `mask` is set.
  void Replace(LaneMask<Lane> mask, const LaneCovariance& next) {
    zz = mask ? next.zz : zz;
    zi = mask ? next.zi : zi;
    zw = mask ? next.zw : zw;
    zd = mask ? next.zd : zd;
    ii = mask ? next.ii : ii;
    iw = mask ? next.iw : iw;
    id = mask ? next.id : id;
    ww = mask ? next.ww : ww;
    wd = mask ? next.wd : wd;
    dd = mask ? next.dd : dd;
  }
};

/// The reading of a channel that a state predicts, without the input's direct part.
template <class Lane>
[[gnu::always_inline]] inline Lane Reading(int channel,
                                           const LaneModel<Lane>& m,
                                           const LaneState<Lane>& x) {
  if (channel == 0) return m.um_z * x.z + m.um_i * x.i;
  return channel == 1 ? x.i : x.w;
}

/// phi x
template <class Lane>
[[gnu::always_inline]] inline LaneState<Lane> Carried(const LaneModel<Lane>& m,
                                                      const LaneState<Lane>& x) {
  return {m.zz * x.z,
          (m.iz * x.z + m.ii * x.i) + (m.iw * x.w + m.id * x.d),
          (m.wz * x.z + m.wi * x.i) + (m.ww * x.w + m.wd * x.d),
          m.dd * x.d};
}

}  // namespace faultlab::core
