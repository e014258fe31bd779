#pragma once

#include <cstdint>
#include <string_view>
#include <variant>
#include <vector>

#include "core/signals/prbs.h"
#include "core/types/result.h"

namespace faultlab::core {

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

/// "prbs", "step", "multisine", "chirp", "samples".
std::string_view Name(const ExcitationSpec& spec);

/// Each refuses by field name; MakeX have Validate(..).ok() as their contract.
Status Validate(const StepSpec& spec, double duration_s);
Status Validate(const MultisineSpec& spec, double period_s);
Status Validate(const ChirpSpec& spec, double period_s);
Status Validate(const SamplesSpec& spec);
std::vector<double> MakeStep(const StepSpec& spec, int samples, double period_s);
std::vector<double> MakeMultisine(const MultisineSpec& spec, int samples, double period_s);
std::vector<double> MakeChirp(const ChirpSpec& spec, int samples, double period_s);

/// uc_v of every sample, round(duration_s / period_s) of them (a list of samples keeps its own
/// length and ignores duration_s). Refuses with kInvalid and `field` = the spec's member, or
/// "duration_s", "period_s". At most kExcitationSamplesMax samples, else kTooLarge.
Result<std::vector<double>> Generate(const ExcitationSpec& spec,
                                     double duration_s,
                                     double period_s);

inline constexpr int kExcitationSamplesMax = 10'000'000;

}  // namespace faultlab::core
