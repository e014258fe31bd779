#pragma once

#include <string>
#include <vector>

namespace faultlab::server {

struct IsolabilityCommandOptions {
  std::string profile = "bench";
  std::string excitation = "prbs";  ///< see ParseExcitation
  std::string channels = "um";
  int window_samples = 100;         ///< of the fault, 10 ms each
  std::vector<std::string> faults;  ///< "R1=10"; empty: the paper's 18
  bool json = false;
  std::string output;  ///< FILE.png or FILE.json of the figure; empty: none
};

/// Judges a fault set on the simulated bench: what is visible, how small, what looks like what.
int RunIsolability(const IsolabilityCommandOptions& options);

}  // namespace faultlab::server
