#pragma once

#include "core/filter/rig_parameters.h"
#include "core/types/hum.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The sample without the hum in its um and ia.
Sample WithoutHum(const Sample& sample, const Hum& hum);

/// Takes hum out of readings as they come, and follows it: no mains keeps its frequency. What is
/// left of it in the innovations of a filter that predicts the cleaned readings corrects the two
/// phasors, with a memory of a second (least mean squares), and what turns them corrects the
/// frequency (a phase-locked loop, critically damped), so that the hum is known for some ten
/// seconds after nobody can tell it from a fault. Does nothing where there is no hum. A plain
/// value. Source: B. Widrow et al., Proc. IEEE 63 (1975), adaptive noise cancelling with a
/// sinusoidal reference; F. M. Gardner, Phaselock Techniques, 3rd ed. (2005), chapter 2.
class HumTracker {
 public:
  /// @param noise  of the readings: the clearer of the two tells the frequency
  HumTracker(const Hum& hum, const NoiseLevel& noise, double period_s);

  Sample Clean(const Sample& sample) const {
    return hum_.any() ? WithoutHum(sample, hum_) : sample;
  }
  /// @param um_v  reading minus prediction of a cleaned sample; 0: nothing was read. The caller
  ///              bounds both, so that an outlier turns nothing.
  /// @param ia_a  the same
  void Learn(double t_s, double um_v, double ia_a);

  const Hum& hum() const { return hum_; }

 private:
  Hum hum_;
  NoiseLevel noise_;
  double step_;
};

}  // namespace faultlab::core
