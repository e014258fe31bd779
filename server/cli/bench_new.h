#pragma once

#include <string>

namespace faultlab::server {

struct BenchNewOptions {
  std::string structure = "inverting-amplifier";
  std::string output = "-";  ///< FILE.toml; "-" prints it
};

/// Writes the commented description of the shipped bench of this structure, as a start for a new
/// one.
int RunBenchNew(const BenchNewOptions& options);

}  // namespace faultlab::server
