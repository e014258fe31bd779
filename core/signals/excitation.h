#pragma once

#include <string_view>
#include <vector>

#include "core/signals/prbs.h"
#include "core/types/excitation_spec.h"
#include "core/types/result.h"

namespace faultlab::core {

/// "prbs", "step", "multisine", "chirp", "samples".
std::string_view Name(const ExcitationSpec& spec);

/// Each refuses and names the field. MakeX requires Validate(..).ok() (contract).
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
