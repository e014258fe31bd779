#include "hardware/rig_program/rig_options.h"

#include <CLI/CLI.hpp>

namespace faultlab::hardware {

void AddRigOptions(CLI::App& app, const std::string& program, RigAgentOptions& options) {
  app.add_option("--id", options.id, "Name of the rig; default: the one in --config");
  app.add_option("--lcm", options.lcm_url, "Bus to the server, udpm://239.255.76.67:7667?ttl=1");
  app.add_option("--config", options.config_file, "Bench TOML; without it the bench is simulated");
  app.add_option(
      "--bench", options.bench, "FILE.toml that describes the bench, default the paper's");
  app.add_option("--profile", options.profile, "A simulator of the bench, default its first");
  app.add_option("--speed", options.speed, "Of the simulated bench")->capture_default_str();
  app.add_option("--keys", options.key_directory, "Folder with ID.key, default ~/.faultlab/keys");
  app.add_option("--state",
                 options.state_directory,
                 "Folder with ID.epoch, the highest epoch seen, default ~/.faultlab/state; "
                 "no lease is given when it cannot be written");
  app.add_option("--ride-through",
                 options.ride_through_s,
                 "Seconds that a run goes on when its server falls silent")
      ->capture_default_str();
  app.add_flag("--self-test", options.self_test, "Walk the relay positions, print, exit");
  app.add_flag("--contacts",
               options.contacts,
               "With --self-test and the supply on: recognise each position by its effect; the "
               "motor turns")
      ->needs("--self-test");
  app.add_flag("--json", options.json, "With --self-test: the report as JSON");
  app.add_flag("!--no-supervisor", options.supervise, "No second process that guards the first");
  std::string examples = "Examples:";
  for (const char* example :
       {" --id bench-1 --config rig.toml --lcm 'udpm://239.255.76.67:7667?ttl=1'",
        " --id far-sim --profile multisim --lcm 'udpm://239.255.76.67:7667?ttl=1'",
        " --id bench-1 --config rig.toml --self-test",
        " --id bench-1 --config rig.toml --self-test --contacts"}) {
    examples += "\n  " + program + example;
  }
  app.footer(examples);
}

}  // namespace faultlab::hardware
