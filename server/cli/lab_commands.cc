#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "hardware/lcm/rig_agent_program.h"
#include "server/app/serve.h"
#include "server/cli/add_command.h"
#include "server/cli/bench_option.h"
#include "server/cli/commands.h"
#include "server/cli/lcm_log_command.h"

namespace faultlab::server {
namespace {

class LabCommands {
 public:
  LabCommands(CLI::App& app, std::function<int()>& chosen) {
    AddServe(app, chosen);
    AddRig(app, chosen);
    AddLcm(app, chosen);
  }

 private:
  void AddServe(CLI::App& app, std::function<int()>& chosen) {
    CLI::App& serve = AddCommand(app,
                                 "serve",
                                 "Server, web page, embedded database and simulated rigs",
                                 serve_,
                                 &Serve,
                                 chosen);
    serve.add_option("--config", serve_.config_path, "TOML file with settings");
    serve.add_option("--listen", serve_.listen, "HOST:PORT, default 127.0.0.1:8080");
    serve.add_option("--data", serve_.data_dir, "Folder of the database, default data");
    serve.add_option("--lcm", serve_.lcm_url, "LCM bus: live tap and remote rigs, udpm://..");
    serve.add_option("--bench",
                     serve_.benches,
                     "FILE.toml or a shipped bench (paper, servo-motor, gear-motor); repeat for "
                     "several, the usual one first");
    serve.add_option("--sim-rigs", serve_.sim_rigs, "Number of simulated rigs");
    serve.add_option("--sim-speed", serve_.sim_speed, "1 = real time; 20 = 20 s take 1 s");
    serve.add_option("--fixture-seed", serve_.fixture_seed, "Seed of runs that name none");
    serve.add_option("--log-level", serve_.log_level, "trace, debug, info, warn or error");
    serve.footer(
        "Examples:\n"
        "  faultlab serve                                  http://localhost:8080, data in ./data\n"
        "  faultlab serve --listen 127.0.0.1:9000 --data /var/lib/faultlab\n"
        "  faultlab serve --lcm 'udpm://239.255.76.67:7667?ttl=1'    then: lcm-logger, faultlab "
        "rig");
  }

  void AddRig(CLI::App& app, std::function<int()>& chosen) {
    CLI::App& rig = AddCommand(app,
                               "rig",
                               "Agent beside a bench, or a simulated bench on another machine",
                               rig_,
                               &hardware::RunRigAgent,
                               chosen);
    rig.add_option("--id", rig_.id, "Name of the rig; default: the one in --config");
    rig.add_option("--lcm", rig_.lcm_url, "Bus to the server, udpm://239.255.76.67:7667?ttl=1");
    rig.add_option("--config", rig_.config_file, "Bench TOML; without it the bench is simulated");
    AddBench(rig, rig_.bench);
    rig.add_option("--profile", rig_.profile, "A simulator of the bench, default its first");
    rig.add_option("--speed", rig_.speed, "Of the simulated bench")->capture_default_str();
    rig.add_option("--keys", rig_.key_directory, "Folder with ID.key, default ~/.faultlab/keys");
    rig.add_option("--state",
                   rig_.state_directory,
                   "Folder with ID.epoch, the highest epoch seen, default ~/.faultlab/state; "
                   "no lease is given when it cannot be written");
    rig.add_option("--ride-through",
                   rig_.ride_through_s,
                   "Seconds that a run goes on when its server falls silent")
        ->capture_default_str();
    rig.add_flag("--self-test", rig_.self_test, "Walk the relay positions, print, exit");
    rig.add_flag("--contacts",
                 rig_.contacts,
                 "With --self-test and the supply on: recognise each position by its effect; the "
                 "motor turns")
        ->needs("--self-test");
    rig.add_flag("--json", rig_.json, "With --self-test: the report as JSON");
    rig.add_flag("!--no-supervisor", rig_.supervise, "No second process that guards the first");
    rig.footer(
        "Examples:\n"
        "  faultlab rig --id bench-1 --config rig.toml --lcm 'udpm://239.255.76.67:7667?ttl=1'\n"
        "  faultlab rig --id far-sim --profile multisim --lcm 'udpm://239.255.76.67:7667?ttl=1'\n"
        "  faultlab rig --id bench-1 --config rig.toml --self-test\n"
        "  faultlab rig --id bench-1 --config rig.toml --self-test --contacts");
  }

  void AddLcm(CLI::App& app, std::function<int()>& chosen) {
    CLI::App& lcm = *app.add_subcommand("lcm", "Recordings to and from logs of the LCM tools");
    lcm.require_subcommand(1);
    CLI::App& export_log = AddCommand(lcm,
                                      "export",
                                      "A recording as lcm-logger would have written it",
                                      lcm_export_,
                                      &RunLcmExport,
                                      chosen);
    export_log
        .add_option("RECORDING", lcm_export_.recording, "CSV file, or the id of a stored run")
        ->required();
    export_log.add_option("-o,--output", lcm_export_.output, "LCM log to write")->required();
    AddBench(export_log, lcm_export_.bench);
    export_log.add_option("--rig", lcm_export_.rig, "Channel FAULTLAB.<rig>.SAMPLE")
        ->capture_default_str();
    export_log.add_option("--run", lcm_export_.run, "Name of the run on the bus");
    export_log.add_option("--data", lcm_export_.data_dir, "Folder of the server's database")
        ->capture_default_str();
    CLI::App& import_log = AddCommand(lcm,
                                      "import",
                                      "A run out of a log of lcm-logger, as CSV",
                                      lcm_import_,
                                      &RunLcmImport,
                                      chosen);
    import_log.add_option("LOG", lcm_import_.log, "File of lcm-logger")->required();
    import_log.add_option("-o,--output", lcm_import_.output, "FILE.csv or FILE.csv.gz")->required();
    AddBench(import_log, lcm_import_.bench);
    import_log.add_option("--run", lcm_import_.run, "Which run; default the first in the log");
    lcm.footer(
        "Examples:\n"
        "  faultlab lcm export run.csv -o run.lcm && lcm-logplayer run.lcm\n"
        "  lcm-logger -f seen.lcm        while `faultlab serve --lcm URL` runs something\n"
        "  faultlab lcm import seen.lcm -o seen.csv && faultlab diagnose seen.csv");
  }

  ServeOptions serve_;
  hardware::RigAgentOptions rig_;
  LcmExportOptions lcm_export_;
  LcmImportOptions lcm_import_;
};

}  // namespace

CommandGroup AddLabCommands(CLI::App& app, std::function<int()>& chosen) {
  return std::make_shared<const LabCommands>(app, chosen);
}

}  // namespace faultlab::server
