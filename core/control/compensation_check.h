#pragma once

#include "core/control/speed_model.h"

namespace faultlab::core {

/// Whether a rig moves as a diagnosis has it. The healthy model and that of the diagnosis predict
/// the speed from the same inputs, each drawn slowly to the readings; the CUSUM of the log
/// likelihood ratio of their errors tells when the diagnosis leaves more than 0.3 of what is left
/// without one.
/// Source: E. S. Page, Continuous inspection schemes, Biometrika 41 (1954), pp. 100-115; choosing
/// by what the data refute: M. G. Safonov, T.-C. Tsao, The unfalsified control concept and
/// learning, IEEE Trans. Automatic Control 42 (1997), pp. 843-847.
class CompensationCheck {
 public:
  /// @param speed_rad_s  newest reading
  /// @param noise_rad_s  standard deviation of a reading
  /// @param input_v      the rig's input so far, as if it had been constant
  CompensationCheck(const LaggedModel& healthy,
                    const LaggedModel& believed,
                    double speed_rad_s,
                    double input_v,
                    double noise_rad_s);

  /// @param speed_rad_s  the next reading, a period later; not finite: there was none
  /// @param u_v  mean input since the last
  /// @returns true from then on when the diagnosis is refuted
  bool Push(double speed_rad_s, double u_v);

  /// The state of the believed amplifier's lag, V of input, at the newest reading.
  double lag_v() const { return believed_.lag_v; }

 private:
  struct Racer {
    LaggedModel model;
    double lag_v;
    double speed_rad_s;

    void Begin(double reading_rad_s, double u_v);
    void Predict(double u_v);
  };
  Racer healthy_;
  Racer believed_;
  double noise_rad_s_;
  bool begun_ = false;
  double sum_ = 0.0;
};

}  // namespace faultlab::core
