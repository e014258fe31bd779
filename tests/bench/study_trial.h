#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "core/diagnosis/pipeline.h"
#include "core/isolability/isolability.h"
#include "core/signals/random.h"

namespace faultlab::study {

/// One set of conditions under which faults are simulated.
struct Case {
  const char* name;
  double um_noise_v = 0.015;
  double clock_s = 0.01;
  double tolerance = 0.0;  ///< each component of the real rig is off its data sheet by up to this
  bool um_only = false;
  double at_from_s = 8.0;
  double at_to_s = 12.0;
};

/// The outcome of one fault in one simulated record.
struct Outcome {
  bool calibrated = false;
  bool false_alarm = false;  ///< before the fault
  double delay_samples = std::numeric_limits<double>::infinity();
  bool isolated_1s = false;
  bool isolated = false;  ///< at the end of the record
  bool bound = false;     ///< only a bound was given, and it holds
  double error = std::numeric_limits<double>::quiet_NaN();  ///< relative, of the true component
  bool covered = false;        ///< the truth lies within 1.96 stated standard errors
  double cramer_rao_sd = 0.0;  ///< of log(value), see CramerRaoSd
};

/// Runs one record of 20 s through a live pipeline; its tasks are run at once.
/// @param relative_value  size.value is a factor on the rig's own value
/// @param verbose  prints unexpected outcomes
Outcome RunTrial(const Case& setting,
                 const core::FaultSize& size,
                 std::uint64_t seed,
                 bool relative_value,
                 bool verbose);

/// A rig each of whose components is off its data sheet by up to `tolerance`.
core::PlantParameters DrawRig(double tolerance, core::Random& random);
void SolveTasks(core::Pipeline& pipeline);
std::string Describe(const core::Verdict& verdict);

}  // namespace faultlab::study
