#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/filter/rig_parameters.h"
#include "core/types/sample.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {

inline constexpr int kOutputCount = 3;  ///< um, ia, motor speed

/// A sample as the prediction model uses it.
struct Observation {
  double u_prev = 0.0;                   ///< input held until the edge of this sample
  double u = 0.0;                        ///< input after the edge
  std::array<double, kOutputCount> y{};  ///< um (V), ia (A), w (rad/s, motor shaft)
  std::uint8_t mask = 0;                 ///< bit c set: y[c] is a reading
  std::int8_t clipped = 0;               ///< +1/-1: um is at that rail and is only a bound
  bool restart = false;                  ///< the state before this sample is not known
};

/// Variance of the rounding of a speed reading ((rad/s)^2), uniform over a step.
/// @param step_s  BenchChannel::step_s
constexpr double RoundingVariance(double w_rad_s, double step_s) {
  const double step = w_rad_s * w_rad_s * step_s;
  return step * step / 12.0;
}

/// What channels read at zero: um (V), ia (A), w (rad/s, motor shaft).
using ReadingZeros = std::array<double, kOutputCount>;

/// Turns samples into observations one by one, by the rule of SampleIntake: repeated and late
/// samples are dropped; a missing sample or a missing input restarts the state.
class ObservationBuilder {
 public:
  /// @param zeros  taken out of the readings
  ObservationBuilder(const ReadingRules& rules,
                     Channels channels,
                     double period_s,
                     double um_rail_v,
                     const ReadingZeros& zeros = {});

  /// False: the sample contains nothing to use.
  bool Push(const Sample& sample, Observation& out);

 private:
  ReadingRules rules_;
  unsigned channels_;  ///< bit c: channel c is used
  double rad_per_s_of_rpm_;
  ReadingZeros zeros_;
  SampleIntake intake_;
  double last_u_ = 0.0;  ///< of the last row
  double used_u_ = 0.0;  ///< of its observation
  bool has_last_ = false;
};

/// @param t_s  gets the run time of each observation
std::vector<Observation> MakeObservations(std::span<const Sample> samples,
                                          const ReadingRules& rules,
                                          Channels channels,
                                          double period_s,
                                          double um_rail_v,
                                          const ReadingZeros& zeros = {},
                                          std::vector<double>* t_s = nullptr);

}  // namespace faultlab::core
