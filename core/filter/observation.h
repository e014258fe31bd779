#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/filter/rig_parameters.h"
#include "core/filter/step_age.h"
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
  /// Of an innovation of y[c] that is whitened by the noise, so much counts: 1, or less where the
  /// model leaves more than noise (ModelError::growth). The state believes y[c] all the same: what
  /// is left after a step is mostly of the state.
  std::array<double, kOutputCount> trust{1.0, 1.0, 1.0};
};

/// Variance of the rounding of a speed reading ((rad/s)^2), uniform over a step.
/// @param step_s  BenchChannel::step_s
constexpr double RoundingVariance(double w_rad_s, double step_s) {
  const double step = w_rad_s * w_rad_s * step_s;
  return step * step / 12.0;
}

/// What channels read at zero: um (V), ia (A), w (rad/s, motor shaft).
using ReadingZeros = std::array<double, kOutputCount>;

/// What is known of a rig's readings, beside their noise.
struct ReadingErrors {
  ReadingZeros zeros{};  ///< taken out of the readings
  ModelError left;       ///< gives Observation::trust
};
ReadingErrors ErrorsOf(const Calibration& calibration);

/// Gives the observations of a record, in their order, the trust that `error` leaves them.
class ReadingTrust {
 public:
  ReadingTrust(const ModelError& error, double period_s) : error_(error), age_(period_s) {}
  void Give(Observation& observation);

 private:
  ModelError error_;
  StepAge age_;
};
void GiveTrust(const ModelError& error, double period_s, std::span<Observation> stretch);

/// Turns samples into observations one by one, by the rule of SampleIntake: repeated and late
/// samples are dropped; a missing sample or a missing input restarts the state.
class ObservationBuilder {
 public:
  ObservationBuilder(const ReadingRules& rules,
                     Channels channels,
                     double period_s,
                     double um_rail_v,
                     const ReadingErrors& errors = {});

  /// False: the sample contains nothing to use.
  bool Push(const Sample& sample, Observation& out);

 private:
  bool IsRead(std::size_t channel, double y) const;

  ReadingRules rules_;
  unsigned channels_;  ///< bit c: channel c is used
  double rad_per_s_of_rpm_;
  ReadingZeros zeros_;
  ReadingTrust trust_;
  SampleIntake intake_;
  double last_u_ = 0.0;  ///< of the last row
  double used_u_ = 0.0;  ///< of its observation
  bool has_last_ = false;
  /// The speed by the data sheet, half as fast to follow, where it goes to, and how much of it is
  /// kept in a period.
  double expected_rad_s_ = 0.0;
  double settled_rad_s_ = 0.0;
  double kept_;
};

/// @param t_s  gets the run time of each observation
std::vector<Observation> MakeObservations(std::span<const Sample> samples,
                                          const ReadingRules& rules,
                                          Channels channels,
                                          double period_s,
                                          double um_rail_v,
                                          const ReadingErrors& errors = {},
                                          std::vector<double>* t_s = nullptr);

}  // namespace faultlab::core
