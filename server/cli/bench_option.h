#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "core/structures/structures.h"
#include "hardware/bench/shipped_benches.h"

namespace faultlab::server {

/// --bench FILE, which every command about one class of rigs has.
inline void AddBench(CLI::App& command, std::string& bench) {
  command.add_option("--bench", bench, "FILE.toml that describes the bench, default the paper's");
}

/// "paper, servo-motor": the descriptions that are built in.
inline std::string ShippedNames() {
  std::string names;
  for (const hardware::ShippedBench& each : hardware::ShippedBenches()) {
    names += (names.empty() ? "" : ", ") + std::string(each.name);
  }
  return names;
}

/// "inverting-amplifier, motor-driver"
inline std::string StructureNames() {
  std::string names;
  for (const core::Structure* each : core::Structures()) {
    names += (names.empty() ? "" : ", ") + std::string(each->name);
  }
  return names;
}

}  // namespace faultlab::server
