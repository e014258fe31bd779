#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/plant/profile.h"
#include "core/plant/propagator.h"
#include "core/signals/random.h"
#include "core/types/component.h"
#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// What the rig's own wires carry at this instant, without converters and noise.
struct PlantOutputs {
  double uc_v = 0.0;
  double ua_v = 0.0;         ///< amplifier output, before R1
  double um_v = 0.0;         ///< behind R1, over the motor
  double ia_a = 0.0;         ///< armature current
  double omega_rad_s = 0.0;  ///< motor shaft
  double angle_rad = 0.0;    ///< motor shaft, for pulse counting
};

/// Amplifier, relays and motor of one rig (paper Eq. (1)-(2)):
///   Zf = Re2 || (R5 + 1/(s C8)),  Uout = Zf/Re1 Uc (1 + gain error), limited to the supply
///   La di/dt = Uout - (Ra+R1) i - Ke w,   J dw/dt = KT i - B w - Mf(w)
/// State (vC8, i, w). Between events (standstill, break-away, reversal, output limit) the system is
/// linear with a held input: advanced by matrix exponentials, exact for any step and any stiffness.
/// The Stribeck term, felt at low speed only, is held over sub-steps of at most 0.1 ms by the
/// midpoint rule; the friction noise is exact at the ends of each Advance and held between.
/// Cost: about 0.1 us for a step whose length and parameters are known; no allocation in Advance.
/// Starts at rest, input 0, C8 uncharged. Deterministic in the seed. Not thread-safe; copyable.
class Plant {
 public:
  /// Contract: positive parameters; friction Ms >= Mc >= 0.
  Plant(const PlantParameters& parameters, const BenchProfile& profile, std::uint64_t seed);

  /// Control voltage from now on, as the DAC holds it.
  void SetInput(double uc_v);
  /// A relay connects another part: acts at once. C8 comes uncharged.
  void Set(Component component, double value);
  /// The part itself changes a little (drift): C8 keeps its charge.
  void Drift(Component component, double value);
  /// Coulomb and static friction from now on (an unlisted fault).
  void SetFriction(double mc_nm, double ms_nm);
  /// Moves time forward. Contract: 0 <= seconds <= 1.
  void Advance(double seconds);

  PlantOutputs outputs() const;
  const PlantParameters& parameters() const { return parameters_; }
  const FrictionModel& friction() const { return friction_; }
  bool standing() const { return direction_ == 0; }
  /// (vC8 volt, i ampere, w rad/s)
  const Eigen::Vector3d& state() const { return x_; }
  /// Contract: finite; w != 0 means turning that way.
  void SetState(const Eigen::Vector3d& state);

 private:
  enum class AmplifierState { kLinear, kClampedHigh, kClampedLow };

  double low_limit_v() const;
  double clamp_v() const;
  /// Output voltage that the amplifier wants; more than the supply gives when clamped.
  double wanted_output_v(const Eigen::Vector3d& x) const;
  double output_v(const Eigen::Vector3d& x) const;
  double torque_nm(double omega_rad_s) const;
  bool follows_current() const;

  void UpdateAmplifier();
  void UpdateDirection();
  double Step(double remaining_s);
  Eigen::Vector3d Propagate(const Eigen::Vector3d& x,
                            double torque_nm,
                            double step_s,
                            double* angle);
  Eigen::Vector3d Midpoint(double step_s, double* angle);
  bool Valid(const Eigen::Vector3d& x) const;

  PlantParameters parameters_;
  FrictionModel friction_;
  AmplifierModel amplifier_;
  PropagatorCache propagators_;
  Random random_;
  Eigen::Vector3d x_ = Eigen::Vector3d::Zero();
  double uc_v_ = 0.0;
  double angle_rad_ = 0.0;
  double friction_noise_nm_ = 0.0;
  int direction_ = 0;  ///< sense of rotation, 0 = standing
  AmplifierState amplifier_state_ = AmplifierState::kLinear;
};

}  // namespace faultlab::core
