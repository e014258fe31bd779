#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/bench/profile.h"
#include "core/plant/propagator.h"
#include "core/signals/random.h"
#include "core/types/component.h"
#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// The electrical and mechanical quantities of the rig at this instant, without converters and
/// noise.
struct PlantOutputs {
  double uc_v = 0.0;
  double ua_v = 0.0;         ///< amplifier output, before Rs
  double um_v = 0.0;         ///< behind Rs, over the motor
  double ia_a = 0.0;         ///< armature current
  double omega_rad_s = 0.0;  ///< motor shaft
  double angle_rad = 0.0;    ///< motor shaft, for pulse counting
};

/// Amplifier, relays and motor of one rig (paper Eq. (1)-(2)); response as in
/// core/types/structure.h:
///   Uout = gain direct (1 + gain error) Uc + (1 - direct) v, limited to the supply
///   lead dv/dt = Uout - v     (v: voltage of the amplifier's capacitor)
///   La di/dt = Uout - (Ra+Rs) i - Ke w,   J dw/dt = KT i - B w - Mf(w)
/// State (v, i, w). Between events (standstill, break-away, reversal, output limit) the system is
/// linear with a held input: advanced by matrix exponentials, exact for any step and any stiffness.
/// The Stribeck term, which acts at low speed only, is held over sub-steps of at most 0.1 ms by the
/// midpoint rule; the friction noise is exact at the ends of each Advance and held between them.
/// Cost: about 0.1 us for a step whose length and parameters are known; no allocation in Advance.
/// A structure that drives a current (Structure::source_ohm) holds i at k (1 + gain error) Uc where
/// the supply lets it: then Uout is what that takes, and drives i as fast as it can after a step.
/// Starts at rest, input 0, capacitor uncharged. Deterministic in the seed. Not thread-safe;
/// copyable.
class Plant {
 public:
  /// Contract: positive parameters; friction Ms >= Mc >= 0.
  Plant(const PlantParameters& parameters, const BenchProfile& profile, std::uint64_t seed);

  /// Sets the control voltage, which the DAC then holds.
  void SetInput(double uc_v);
  /// A relay connects another part; acts at once. A capacitor is uncharged when it is connected.
  void Set(Component component, double value);
  /// The value of the same part changes (drift): a capacitor keeps its charge.
  void Drift(Component component, double value);
  /// Sets Coulomb and static friction (an unlisted fault).
  void SetFriction(double mc_nm, double ms_nm);
  /// Moves time forward. Contract: 0 <= seconds <= 1.
  void Advance(double seconds);

  PlantOutputs outputs() const;
  const PlantParameters& parameters() const { return parameters_; }
  const FrictionModel& friction() const { return friction_; }
  bool standing() const { return direction_ == 0; }
  /// (v volt, i ampere, w rad/s)
  const Eigen::Vector3d& state() const { return x_; }
  /// Contract: finite; w != 0 means that the motor turns in that direction.
  void SetState(const Eigen::Vector3d& state);

 private:
  enum class AmplifierState { kLinear, kClampedHigh, kClampedLow };

  double high_limit_v() const { return amplifier_.output_max_v; }
  double low_limit_v() const;
  double current_reference_a() const;
  bool drives_current() const { return parameters_.structure->drives_current(); }
  LinearRegime regime() const;
  double drive() const;

  /// Output voltage that the amplifier needs to follow its input.
  double WantedOutput(const Eigen::Vector3d& x) const;
  double Output(const Eigen::Vector3d& x) const;
  double FrictionTorque(double omega_rad_s) const;
  double BreakawayTorque() const;
  bool StribeckActs(const Eigen::Vector3d& x) const;

  void ParametersChanged();
  void UpdateFrictionNoise(double seconds);
  void ResolveAmplifier();
  void ResolveMotion();
  /// True when x cannot belong to the present regime, so that an event lies before it.
  bool AmplifierLeaves(const Eigen::Vector3d& x) const;
  bool MotionLeaves(const Eigen::Vector3d& x) const;

  struct Reached {
    Eigen::Vector3d x;
    double angle_rad;
  };
  Reached Apply(const Propagator& propagator, const Eigen::Vector3d& x, double torque_nm) const;
  /// One step in the present regime, Stribeck term by the midpoint rule.
  Reached StepTo(double step_s, bool remember);
  bool TryWholeStep(double seconds);
  void StepWithEvents(double step_s);
  void Accept(const Reached& reached);

  PlantParameters parameters_;
  FrictionModel friction_;
  AmplifierModel amplifier_;
  PropagatorCache propagators_;
  Random random_;
  Eigen::Vector3d x_ = Eigen::Vector3d::Zero();
  double uc_v_ = 0.0;
  double angle_rad_ = 0.0;
  double friction_noise_nm_ = 0.0;
  double output_per_uc_ = 0.0;  ///< Uout = output_per_uc uc + output_per_v v (voltage mode)
  double output_per_v_ = 0.0;
  double stribeck_speed_max_rad_s_ = 0.0;  ///< above it the term vanishes in double precision
  int direction_ = 0;                      ///< sense of rotation, 0 = standing
  AmplifierState amplifier_state_ = AmplifierState::kLinear;
};

}  // namespace faultlab::core
