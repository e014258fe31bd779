#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace faultlab::server {

struct ControlCommandOptions {
  std::string bench;                  ///< FILE.toml; empty: the paper's
  std::vector<std::string> faults;    ///< see ParseFault
  std::string told;                   ///< a fault that the control is told of; empty: the diagnosis
  std::string reference = "150:170";  ///< LOW:HIGH, rad/s of the motor shaft, in turn
  std::string shape = "steps";        ///< or ramp, prbs: see core::SpeedReference
  std::string controller = "compensated";
  double hold_s = 2.0;
  double duration_s = 30.0;
  std::uint64_t seed = 1;
  bool json = false;
  std::string markdown;  ///< FILE.md: every fault of the bench under every controller
};

/// Runs the speed control of a simulated rig and prints how well the reference was kept, or writes
/// the table of all faults.
int RunControlCommand(const ControlCommandOptions& options);

}  // namespace faultlab::server
