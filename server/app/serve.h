#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/config.h"

namespace faultlab::server {

/// Command line of `faultlab serve`, over the configuration file.
struct ServeOptions {
  std::string config_path;                    ///< empty: no file
  std::vector<std::string> benches;           ///< descriptions, or names of shipped ones
  std::optional<std::string> listen;          ///< "127.0.0.1:8080"; port 0 = any free one
  std::optional<std::string> data_dir;        ///< recordings and database; created when missing
  std::optional<std::string> lcm_url;         ///< live tap and remote rigs
  std::optional<int> sim_rigs;                ///< number of simulated rigs
  std::optional<double> sim_speed;            ///< 1 = real time; 20 = a 20 s run takes 1 s
  std::optional<std::uint64_t> fixture_seed;  ///< seed of runs that name none
  std::optional<std::string> log_level;       ///< trace|debug|info|warn|error
};

/// Runs the server until SIGTERM or SIGINT. Prints `faultlab listening on http://HOST:PORT` on
/// stdout when ready. @returns process exit status: 0 clean, 1 could not start (reason on stderr),
/// 2 bad configuration (file and line on stderr).
int Serve(const ServeOptions& options);

}  // namespace faultlab::server
