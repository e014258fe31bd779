#include "server/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>
#include <functional>
#include <string>

#include "server/cli/commands.h"
#include "server/cli/console.h"

// Parses the command line and calls one function. The commands are in server/cli; server/app
// serves, hardware/lcm is the agent.
namespace faultlab::server {
namespace {

constexpr char kAbout[] =
    "faultlab: a remote laboratory for fault diagnosis of a DC motor and its amplifier.\n\n"
    "Try it without any hardware:\n"
    "  faultlab serve                                          then open http://localhost:8080\n"
    "  faultlab simulate --fault R1=100@10 -o run.csv          20 s of the bench, R1 breaks at 10 "
    "s\n"
    "  faultlab diagnose run.csv                               which component, which value\n"
    "  faultlab plot run.csv --figure signals -o run.png       a picture for the report\n"
    "  faultlab study run.csv                                  how windows trade speed for "
    "noise\n\n"
    "Components: R1, R9, R12 and Ra in ohm, C8 in farad, J in kg m^2, B in Nm/(rad/s).\n"
    "Exit status: 0 done, 1 an output could not be written, 2 an option or a file is wrong\n"
    "(the message on stderr names it).";

}  // namespace

int RunCommandLine(int argc, char** argv) {
  CLI::App app(kAbout, "faultlab");
  app.set_version_flag("--version", "faultlab " + std::string(Version()));
  app.require_subcommand(1);
  std::function<int()> chosen;
  const auto lab = AddLabCommands(app, chosen);
  const auto records = AddRecordCommands(app, chosen);
  const auto model = AddModelCommands(app, chosen);
  const auto admin = AddAdminCommands(app, chosen);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked = error.get_exit_code() == EXIT_SUCCESS;  // --help, --version
    if (!asked && argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      PrintError("unknown command '" + std::string(argv[1]) + "'");
    }
    app.exit(error);
    return asked ? kExitOk : kExitBadInput;
  }
  try {
    return chosen();
  } catch (const std::exception& error) {
    PrintError(std::string("internal error: ") + error.what());
    return kExitFailure;
  }
}

}  // namespace faultlab::server
