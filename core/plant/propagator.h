#pragma once

#include <Eigen/Core>
#include <array>

#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// The conditions that hold during a linear stretch.
struct LinearRegime {
  enum class Output { kAmplifier, kClamped, kCurrent };
  Output output = Output::kAmplifier;  ///< what drives the armature
  bool turning = true;                 ///< false: w = 0
  friend bool operator==(const LinearRegime&, const LinearRegime&) = default;
};

/// Exact step of x = (v, i, w) with held drive u and held friction torque M, and of the angle:
///   x' = A x + b u + g M over `step_s`:   x+ = phi x + gamma_u u + gamma_m M
///   angle+ = angle + angle_x' x + angle_u u + angle_m M
/// u is uc (kAmplifier), the output voltage (kClamped) or the held current (kCurrent).
struct Propagator {
  Eigen::Matrix3d phi;
  Eigen::Vector3d gamma_u;
  Eigen::Vector3d gamma_m;
  Eigen::Vector3d angle_x;
  double angle_u = 0.0;
  double angle_m = 0.0;
};

/// Continuous matrices of a regime, gain error g as a factor (1 + g) on uc.
struct LinearSystem {
  Eigen::Matrix3d a;
  Eigen::Vector3d b;
  Eigen::Vector3d g;
};
LinearSystem MakeLinearSystem(const PlantParameters& parameters,
                              double gain_error,
                              LinearRegime regime);

/// Matrix exponential of the augmented system. Scaling and squaring with a Pade [6/6] kernel:
/// Higham, SIAM J. Matrix Anal. Appl. 26 (2005). About 3 us.
Propagator MakePropagator(const LinearSystem& system, double step_s);

/// Caches the propagators of the last few (regime, step) pairs of one parameter set.
class PropagatorCache {
 public:
  /// Empties the cache, because the parameters changed.
  void Reset(const PlantParameters& parameters, double gain_error);
  /// Cached: for the few step lengths that are used repeatedly. Valid until the next call.
  const Propagator& Get(LinearRegime regime, double step_s);
  /// Not cached: for the step to or from an event.
  Propagator Once(LinearRegime regime, double step_s) const;
  /// True for complex poles: w may overshoot within a long step.
  bool oscillates() const { return oscillates_; }

 private:
  struct Entry {
    LinearRegime regime;
    double step_s = 0.0;  ///< 0 = empty
    Propagator propagator;
  };
  PlantParameters parameters_;
  double gain_error_ = 0.0;
  bool oscillates_ = false;
  std::array<Entry, 6> entries_;
  std::size_t next_ = 0;
};

}  // namespace faultlab::core
