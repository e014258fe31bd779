#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/plant_parameters.h"

namespace faultlab::server {

struct SimulateOptions {
  std::vector<std::string> faults;  ///< see ParseFault
  std::string profile = "bench";
  std::uint64_t seed = 1;  ///< of the noise, and of the excitation unless it names its own
  double duration_s = 20.0;
  double period_s = core::kSamplePeriodSeconds;
  std::string excitation = "prbs";  ///< see ParseExcitation
  std::string output;               ///< FILE.csv[.gz], "-" = standard output
};

/// One run of the simulated bench into a CSV file, which names profile, seed and faults in its
/// comments. The same options give the same bytes.
int RunSimulate(const SimulateOptions& options);

}  // namespace faultlab::server
