#pragma once

#include <string>

#include "hardware/lcm/rig_agent_program.h"

namespace CLI {
class App;
}

namespace faultlab::hardware {

/// Adds the agent's options to `app`; parsing fills `options`, which must outlive it.
/// @param program  as in the examples of its help: "faultlab rig", "faultlab-rig"
void AddRigOptions(CLI::App& app, const std::string& program, RigAgentOptions& options);

}  // namespace faultlab::hardware
