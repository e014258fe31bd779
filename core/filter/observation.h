#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/types/sample.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {

inline constexpr int kOutputCount = 3;  ///< um, ia, motor speed

/// A sample as the prediction model uses it.
struct Observation {
  double u_prev = 0.0;                   ///< input held until this sample's edge
  double u = 0.0;                        ///< input since
  std::array<double, kOutputCount> y{};  ///< um (V), ia (A), w (rad/s, motor shaft)
  std::uint8_t mask = 0;                 ///< bit c set: y[c] is a reading
  std::int8_t clipped = 0;               ///< +1/-1: um stands at that rail, a bound only
  bool restart = false;                  ///< the state before this sample is not known
};

/// Turns samples into observations one by one, by the rule of SampleIntake: repeated and late
/// samples are dropped, a missing sample or a missing input restarts the state.
class ObservationBuilder {
 public:
  ObservationBuilder(Channels channels, double period_s, double um_rail_v)
      : channels_(channels), intake_(period_s, um_rail_v) {}

  /// False: nothing to use in this sample.
  bool Push(const Sample& sample, Observation& out);

 private:
  Channels channels_;
  SampleIntake intake_;
  double last_u_ = 0.0;
  bool has_last_ = false;
};

std::vector<Observation> MakeObservations(std::span<const Sample> samples,
                                          Channels channels,
                                          double period_s,
                                          double um_rail_v);

}  // namespace faultlab::core
