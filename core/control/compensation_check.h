#pragma once

#include "core/control/speed_model.h"

namespace faultlab::core {

/// Whether a rig moves as a diagnosis has it. The healthy model and that of the diagnosis predict
/// the speed from the same inputs, each drawn slowly to the readings; the CUSUM of the log
/// likelihood ratio of their errors tells when the diagnosis leaves more than half of what is left
/// without one.
/// Source: E. S. Page, Continuous inspection schemes, Biometrika 41 (1954), pp. 100-115; choosing
/// by what the data refute: M. G. Safonov, T.-C. Tsao, The unfalsified control concept and
/// learning, IEEE Trans. Automatic Control 42 (1997), pp. 843-847.
class CompensationCheck {
 public:
  /// @param speed_rad_s  newest reading
  /// @param noise_rad_s  standard deviation of a reading
  /// @param lag_share    of the believed model's time constant, what the amplifier's lag makes of
  ///                     it: two states then, of which one is modelled
  CompensationCheck(const SpeedModel& healthy,
                    const SpeedModel& believed,
                    double speed_rad_s,
                    double noise_rad_s,
                    double lag_share);

  /// @param speed_rad_s  the next reading, a period later; not finite: there was none
  /// @param u_v  mean input since the last
  /// @returns true from then on when the diagnosis is refuted
  bool Push(double speed_rad_s, double u_v);

 private:
  SpeedModel healthy_;
  SpeedModel believed_;
  double healthy_rad_s_;
  double believed_rad_s_;
  double noise_rad_s_;
  double model_share_;
  double sum_ = 0.0;
};

}  // namespace faultlab::core
