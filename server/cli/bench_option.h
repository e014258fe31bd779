#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace faultlab::server {

/// --bench FILE, which every command about one class of rigs has.
inline void AddBench(CLI::App& command, std::string& bench) {
  command.add_option("--bench", bench, "FILE.toml that describes the bench, default the paper's");
}

}  // namespace faultlab::server
