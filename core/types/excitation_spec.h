#pragma once

#include <cstdint>
#include <variant>
#include <vector>

namespace faultlab::core {

/// Pseudo-random binary sequence: a maximal length shift register of `order` bits, clocked every
/// `clock_s`. The record of the paper is order 10 (1023 bits), 10 ms, 2 V to 3 V.
struct PrbsSpec {
  double low_v = 2.0;
  double high_v = 3.0;
  double clock_s = 0.01;
  int order = 10;
  std::uint64_t seed = 1;  ///< chooses the phase: the register's first content
};

/// low_v before at_s, high_v from the first sample with t >= at_s.
struct StepSpec {
  double low_v = 2.0;
  double high_v = 3.0;
  double at_s = 1.0;
};

/// offset + amplitude * x(t), x = sum of `lines` cosines of equal power on the harmonics 1..lines
/// of 1/base_period_s with Schroeder phases -pi h (h-1) / lines, scaled to max |x| = 1.
/// At most 500 lines. The seed shifts the start within the base period (seed 0: no shift).
struct MultisineSpec {
  double offset_v = 2.5;
  double amplitude_v = 0.5;
  int lines = 40;
  double base_period_s = 2.0;
  std::uint64_t seed = 1;
};

/// offset + amplitude sin(phi(t)), instantaneous frequency linear from from_hz to to_hz over the
/// whole duration.
struct ChirpSpec {
  double offset_v = 2.5;
  double amplitude_v = 0.5;
  double from_hz = 0.1;
  double to_hz = 20.0;
};

/// One value for each sample; the record is as long as the list.
struct SamplesSpec {
  std::vector<double> uc_v;
};

using ExcitationSpec = std::variant<PrbsSpec, StepSpec, MultisineSpec, ChirpSpec, SamplesSpec>;

}  // namespace faultlab::core
