#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "hardware/rig_program/rig_options.h"

// `faultlab rig` as a program of its own, for a small computer beside the bench: it needs none of
// the server's libraries.
int main(int argc, char** argv) {
  using namespace faultlab;  // NOLINT(google-build-using-namespace)
  constexpr int kBadInput = 2;
  CLI::App app("Agent beside a bench, or a simulated bench on another machine", "faultlab-rig");
  app.set_version_flag("--version", "faultlab-rig " FAULTLAB_VERSION);
  hardware::RigAgentOptions options;
  hardware::AddRigOptions(app, "faultlab-rig", options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    return error.get_exit_code() == EXIT_SUCCESS ? EXIT_SUCCESS : kBadInput;
  }
  try {
    return hardware::RunRigAgent(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "faultlab-rig: internal error: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
