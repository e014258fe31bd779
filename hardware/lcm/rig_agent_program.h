#pragma once

#include <string>

namespace faultlab::hardware {

/// `faultlab rig --id NAME --lcm URL [--config F]`: the program beside a bench, or a simulated
/// bench on another machine.
struct RigAgentOptions {
  std::string id;           ///< --id; empty: the one in config_file, or any with self_test
  std::string lcm_url;      ///< --lcm; empty is allowed with self_test
  std::string config_file;  ///< --config: bench TOML (hardware/README.md); empty = simulated bench
  std::string bench;        ///< --bench: its description; empty: the file's, else the paper's
  std::string profile;      ///< --profile of the simulated bench; empty: its usual one
  double speed = 1.0;       ///< --speed of the simulated bench
  /// --keys DIR: holds ID.key, 64 hex digits; made on the first start. The server needs a copy.
  /// Empty: $HOME/.faultlab/keys
  std::string key_directory;
  /// --state DIR: holds ID.epoch, the highest epoch seen. Without it an older server could command
  /// the rig after a restart: an agent that cannot write there gives no lease.
  /// Empty: $HOME/.faultlab/state
  std::string state_directory;
  /// --ride-through SECONDS: how long a run goes on when its server falls silent; 0 = the watchdog
  /// of 500 ms stops it.
  double ride_through_s = 0.0;
  bool self_test = false;  ///< --self-test: walk the relay positions, print, exit
  /// --contacts, with --self-test: the supply is on, each position is recognised by its effect.
  bool contacts = false;
  bool json = false;  ///< --json, with --self-test
  /// --no-supervisor: without the second process that makes the bench safe when this one is killed
  /// by SIGKILL or drives the motor and stands still. For a debugger.
  bool supervise = true;
};

/// Runs until SIGTERM or SIGINT, or through the self-test. Blocks.
/// @returns exit status: 0 fine, 1 a failed self-test or a bench that could not be made safe,
///          2 bad options or configuration (told on stderr with file and line), 3 no bus.
int RunRigAgent(const RigAgentOptions& options);

}  // namespace faultlab::hardware
