#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"

namespace faultlab::server {

struct MethodsCommandOptions {
  std::string bench;                 ///< FILE.toml; empty: the paper's
  std::vector<std::string> methods;  ///< names; empty: all
  std::string channels;              ///< "um", "all"; empty: as the bench's estimators
  std::string recordings;            ///< folder; empty: simulated runs
  int trials = 10;                   ///< simulated records of each fault
  double hours = 6.0;                ///< healthy, simulated, of each method
  std::uint64_t seed = 1000;
  bool json = false;
  std::string markdown;   ///< FILE.md, "" = none
  bool append = false;    ///< behind what is in FILE.md
  std::string plots_dir;  ///< methods.png there; empty: none
};

/// Refuses (field "method") a name that no method has, and a method made for another bench.
core::Status CheckMethod(const std::string& name, const core::Bench& bench);

/// Every method of the literature on the same records: the paper's Table 21 as figures.
int RunMethods(const MethodsCommandOptions& options);

}  // namespace faultlab::server
