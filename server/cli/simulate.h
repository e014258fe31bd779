#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace faultlab::server {

struct SimulateOptions {
  std::string bench;                ///< FILE.toml; empty: the paper's
  std::vector<std::string> faults;  ///< see ParseFault
  std::string profile;              ///< a simulator of the bench; empty: its usual one
  std::uint64_t seed = 1;           ///< of the noise, and of the excitation unless that has its own
  double duration_s = 20.0;
  std::optional<double> period_s;  ///< nothing: the bench's
  std::string excitation;          ///< see ParseExcitation; empty: the bench's
  std::string output;              ///< FILE.csv[.gz], "-" = standard output
};

/// Writes one run of the simulated bench to a CSV file, whose comments contain profile, seed and
/// faults. The same options give the same bytes.
int RunSimulate(const SimulateOptions& options);

}  // namespace faultlab::server
