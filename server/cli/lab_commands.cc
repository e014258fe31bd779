#include <CLI/CLI.hpp>
#include <memory>

#include "hardware/rig_program/rig_options.h"
#include "server/app/serve.h"
#include "server/cli/add_command.h"
#include "server/cli/bench_option.h"
#include "server/cli/commands.h"
#include "server/cli/lcm_log_command.h"

namespace faultlab::server {
namespace {

class LabCommands : Commands {
 public:
  LabCommands(CLI::App& app, std::function<int()>& chosen) : Commands(chosen) {
    AddServe(app);
    AddRig(app);
    AddLcm(app);
  }

 private:
  void AddServe(CLI::App& app) {
    CLI::App& serve =
        Add(app, "serve", "Server, web page, embedded database and simulated rigs", serve_, &Serve);
    serve.add_option("--config", serve_.config_path, "TOML file with settings");
    serve.add_option("--listen", serve_.listen, "HOST:PORT, default 127.0.0.1:8080");
    serve.add_option("--data", serve_.data_dir, "Folder of the database, default data");
    serve.add_option("--lcm", serve_.lcm_url, "LCM bus: live tap and remote rigs, udpm://..");
    serve.add_option("--bench",
                     serve_.benches,
                     "FILE.toml or a shipped bench (" + ShippedNames() +
                         "); repeat for several, the usual one first");
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

  void AddRig(CLI::App& app) {
    CLI::App& rig = Add(app,
                        "rig",
                        "Agent beside a bench, or a simulated bench on another machine",
                        rig_,
                        &hardware::RunRigAgent);
    hardware::AddRigOptions(rig, "faultlab rig", rig_);
  }

  void AddLcm(CLI::App& app) {
    CLI::App& lcm = *app.add_subcommand("lcm", "Recordings to and from logs of the LCM tools");
    lcm.require_subcommand(1);
    CLI::App& export_log = Add(lcm,
                               "export",
                               "A recording as lcm-logger would have written it",
                               lcm_export_,
                               &RunLcmExport);
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
    CLI::App& import_log =
        Add(lcm, "import", "A run out of a log of lcm-logger, as CSV", lcm_import_, &RunLcmImport);
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
