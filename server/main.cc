#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>
#include <functional>
#include <string>

#include "hardware/lcm/rig_agent_program.h"
#include "server/app/serve.h"
#include "server/cli/admin.h"
#include "server/cli/calibrate.h"
#include "server/cli/console.h"
#include "server/cli/diagnose.h"
#include "server/cli/isolability.h"
#include "server/cli/lcm_log_command.h"
#include "server/cli/plot.h"
#include "server/cli/reproduce.h"
#include "server/cli/retention.h"
#include "server/cli/simulate.h"
#include "server/cli/study.h"

// Only the command line lives here: options are parsed, then one function is called. What a command
// does is in server/cli, server/app and hardware/lcm.
namespace {

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using server::DiagnosisFlags;

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

constexpr char kSimulateExamples[] =
    "Examples:\n"
    "  faultlab simulate --fault R1=100@10 -o r1.csv.gz        R1 = 100 ohm from 10 s on\n"
    "  faultlab simulate --fault R9=18k@5..17 -o drift.csv     R9 drifts to 18 kohm, 5 s to 17 s\n"
    "  faultlab simulate --fault C8=10u@5to8 -o back.csv       10 uF from 5 s to 8 s, then "
    "nominal\n"
    "  faultlab simulate --fault Ra=10@10 --fault R1=5@10 -o double.csv\n"
    "  faultlab simulate --excitation prbs:clock=0.02,low=1,high=4 --duration 60 -o slow.csv\n\n"
    "Excitations: prbs[:low,high,clock,order,seed]  step[:low,high,at]\n"
    "  multisine[:offset,amplitude,lines,base,seed]  chirp[:offset,amplitude,from,to]\n"
    "  file:RECORDING.csv (its uc_v)               volts, seconds, hertz\n"
    "Columns written: t_s, uc_v, um_v, ua_v (V), ia_a (A), n_rpm (behind the 3.8:1 gear).";

constexpr char kDiagnoseExamples[] =
    "Input: CSV with a header of t_s,uc_v,um_v and any of ua_v,ia_a,n_rpm, in any order. Other\n"
    "names and units are read too: 't [ms]', 'Uc (V)', 'um_mV', 'speed_rpm', 'time'. Cells "
    "between\n"
    "commas, semicolons or tabs; decimal commas with the latter two. '#' begins a comment, .gz is\n"
    "read through gzip, '-' is the standard input. An empty cell or NaN is a lost reading; "
    "missing\n"
    "rows are gaps. What was understood beyond the plain names is said on stderr.\n\n"
    "Examples:\n"
    "  faultlab diagnose run.csv                      learns the rig between 0.5 s and 5 s\n"
    "  faultlab diagnose --healthy 1:9 a.csv b.csv.gz a longer fault-free stretch\n"
    "  faultlab diagnose --calibration rig.json x.csv the rig as 'faultlab calibrate' stored it\n"
    "  faultlab diagnose --channels um run.csv        as the paper: voltage alone\n"
    "  faultlab diagnose --values table2 run.csv      faults are values that the relays connect\n"
    "  faultlab diagnose --json runs/ | jq .verdict   every recording of a folder, an object a "
    "line\n\n"
    "Exit status: 0 every file was diagnosed, whatever the verdicts are; 2 a file or an option is\n"
    "wrong (the others are still diagnosed); 1 the output could not be written.";

constexpr char kCalibrateExamples[] =
    "A calibration is what a fault-free stretch says about one rig: its own parameters with their\n"
    "errors, the time from DAC edge to ADC sample, friction, noise, alarm levels. With it a "
    "record\n"
    "needs no fault-free beginning, and every record of the rig is judged alike.\n\n"
    "Examples:\n"
    "  faultlab simulate --duration 60 -o healthy.csv\n"
    "  faultlab calibrate --healthy 0.5:60 healthy.csv -o rig.json\n"
    "  faultlab diagnose --calibration rig.json --healthy 0.2:5 run.csv   watched from 0.2 s on\n\n"
    "Exit status: 2 when the stretch is refused; the message names the check and what to do.";

constexpr char kStudyExamples[] =
    "The paper's Figures 17-20 with your windows: K samples of SWA, K of SIA whose integrals are "
    "m\n"
    "long. For each window: mean and spread of its settled estimates before and after the change,\n"
    "the standard error that they state, and how long they take to settle. A short window settles\n"
    "sooner, a long one spreads less; an input too poor for a window shows as not excited.\n\n"
    "Examples:\n"
    "  faultlab study run.csv                            the paper's six windows\n"
    "  faultlab study run.csv --k 25,50,400 --km \"\"       SWA alone\n"
    "  faultlab study run.csv --km 100:5,100:20,100:50 --k \"\" --exact --plots figures\n"
    "  faultlab study run.csv --change 10 --json | jq .variants";

constexpr char kPlotExamples[] =
    "Figures: signals (Uc, Um, Ia, n), swa and sia (estimates with their windows), models "
    "(measured\n"
    "Um beside simulated models, fit in percent). A name that ends in .json gets the figure's "
    "data.\n\n"
    "Examples:\n"
    "  faultlab plot run.csv --figure sia -o sia.png\n"
    "  faultlab plot run.csv.gz --figure models --scale 2 -o print.png\n"
    "  faultlab plot RUN-ID --data data --figure signals -o run.png";

void AddDiagnosisFlags(CLI::App& command, DiagnosisFlags& flags) {
  command.add_option("--healthy", flags.healthy, "Fault-free stretch FROM:TO in seconds")
      ->capture_default_str();
  command.add_option("--channels", flags.channels, "Channels to use: um or all")
      ->capture_default_str();
  command
      .add_option("--values",
                  flags.values,
                  "table2: a fault has a value that the relays can connect; none: any value")
      ->capture_default_str();
  command.add_option("--calibration",
                     flags.calibration,
                     "FILE.json of 'faultlab calibrate', in place of the record's own start");
}

/// Adds a subcommand whose options live as long as the program and whose `run` gives the status.
template <typename Options>
CLI::App& AddCommand(CLI::App& app,
                     const std::string& name,
                     const std::string& about,
                     Options& options,
                     int (*run)(const Options&),
                     std::function<int()>& chosen) {
  CLI::App& command = *app.add_subcommand(name, about);
  command.callback([&options, run, &chosen] { chosen = [&options, run] { return run(options); }; });
  return command;
}

void AddTarget(CLI::App& command, server::AdminTarget& target) {
  command.add_option("--data", target.data_dir, "Folder of the server's database")
      ->capture_default_str();
  command.add_option("--database", target.database_url, "postgresql://.. instead of the folder");
}

/// `faultlab admin ..`: everything that works on the database without the server.
class AdminCommands {
 public:
  AdminCommands(CLI::App& app, std::function<int()>& chosen) {
    CLI::App& admin = *app.add_subcommand("admin", "Users, keys, backup, restore, check, rehearse");
    admin.require_subcommand(1);
    admin.footer(
        "Examples:\n"
        "  faultlab admin users add ana --name \"Ana Petrović\" --role instructor\n"
        "  faultlab admin keys add ana --scope runs:read --scope runs:write --days 30\n"
        "  faultlab admin backup /var/backups/lab.db        while the server works\n"
        "  faultlab admin rehearse --steps 1000000 --seed 1 the scheduler on a fake clock");
    AddUsers(admin, chosen);
    AddKeys(admin, chosen);
    CLI::App& backup = AddCommand(admin,
                                  "backup",
                                  "A consistent copy, while others work",
                                  backup_,
                                  &server::RunBackup,
                                  chosen);
    CLI::App& restore = AddCommand(
        admin, "restore", "A backup into an empty folder", restore_, &server::RunRestore, chosen);
    backup.add_option("FILE", backup_.file, "New file")->required();
    restore.add_option("FILE", restore_.file, "Made by backup")->required();
    AddTarget(backup, backup_.target);
    AddTarget(restore, restore_.target);
    AddTarget(
        AddCommand(admin, "check", "Integrity of the database", check_, &server::RunCheck, chosen),
        check_);
    AddRetention(admin, chosen);
    CLI::App& rehearse = AddCommand(admin,
                                    "rehearse",
                                    "The scheduler against random people, failures and crashes",
                                    rehearse_,
                                    &server::RunRehearse,
                                    chosen);
    rehearse.add_option("--steps", rehearse_.steps, "Random inputs")->capture_default_str();
    rehearse.add_option("--seed", rehearse_.seed, "Same seed, same report")->capture_default_str();
    rehearse.add_option("--weeks", rehearse_.weeks, "Simulated weeks")->capture_default_str();
    rehearse.add_flag("--json", rehearse_.json, "The report as one JSON object");
  }

 private:
  void AddRetention(CLI::App& admin, std::function<int()>& chosen) {
    CLI::App& command = AddCommand(admin,
                                   "retention",
                                   "Deletes what was kept long enough, as the server does daily",
                                   retention_,
                                   &server::RunRetention,
                                   chosen);
    AddTarget(command, retention_.target);
    command.add_flag("--dry-run", retention_.dry_run, "Only shows what would go");
    command.add_flag("--json", retention_.json, "One JSON object");
    server::lab::RetentionRules& rules = retention_.rules;
    command.add_option("--guest-days", rules.guest_days, "Recordings of guests; 0 = for ever");
    command.add_option("--student-days", rules.student_days, "Recordings, after the last course");
    command.add_option("--job-days", rules.job_days, "Jobs and the recordings of their runs");
    command.add_option("--news-days", rules.news_days, "What users were told, old links");
    for (CLI::Option* option : command.get_options()) {
      if (option->get_name().ends_with("-days")) option->capture_default_str();
    }
  }
  void AddUsers(CLI::App& admin, std::function<int()>& chosen) {
    CLI::App& users = *admin.add_subcommand("users", "Accounts");
    users.require_subcommand(1);
    AddTarget(AddCommand(users, "list", "All accounts", list_, &server::RunUserList, chosen),
              list_);
    struct Action {
      const char* name;
      const char* about;
      int (*run)(const server::UserOptions&);
    };
    for (const Action& action :
         {Action{"add", "Make an account, print its one-time link", &server::RunUserAdd},
          Action{"link", "A new one-time link that sets the password", &server::RunUserLink},
          Action{"disable", "End its sign-ins and keys", &server::RunUserDisable},
          Action{"enable", "Let it in again", &server::RunUserEnable}}) {
      CLI::App& command = AddCommand(users, action.name, action.about, user_, action.run, chosen);
      command.add_option("LOGIN", user_.login, "3 to 64 of a-z 0-9 . _ @ -")->required();
      AddTarget(command, user_.target);
      if (action.run == &server::RunUserAdd) {
        command.add_option("--name", user_.name, "As others see it, in any script");
        command.add_option("--role", user_.role, "student, instructor, operator, admin or service")
            ->capture_default_str();
      }
    }
  }

  void AddKeys(CLI::App& admin, std::function<int()>& chosen) {
    CLI::App& keys = *admin.add_subcommand("keys", "API keys of an account");
    keys.require_subcommand(1);
    CLI::App& add =
        AddCommand(keys, "add", "Make a key, print it once", key_, &server::RunKeyAdd, chosen);
    CLI::App& list =
        AddCommand(keys, "list", "All keys of an account", key_, &server::RunKeyList, chosen);
    CLI::App& revoke = AddCommand(keys, "revoke", "End a key", key_, &server::RunKeyRevoke, chosen);
    for (CLI::App* command : {&add, &list, &revoke}) {
      command->add_option("LOGIN", key_.login, "Account")->required();
      AddTarget(*command, key_.target);
    }
    add.add_option("--name", key_.name, "What it is for")->capture_default_str();
    add.add_option("--scope", key_.scopes, "runs:read, runs:write, jobs, lab; repeatable");
    add.add_option("--days", key_.days, "Good for, at most 400")->capture_default_str();
    revoke.add_option("ID", key_.id, "Number of the key")->required();
  }

  server::AdminTarget list_;
  server::AdminTarget check_;
  server::UserOptions user_;
  server::KeyOptions key_;
  server::BackupOptions backup_;
  server::BackupOptions restore_;
  server::RetentionOptions retention_;
  server::RehearseOptions rehearse_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kAbout, "faultlab");
  app.set_version_flag("--version", "faultlab " + std::string(server::Version()));
  app.require_subcommand(1);
  std::function<int()> chosen;

  server::ServeOptions serve_options;
  CLI::App& serve = AddCommand(app,
                               "serve",
                               "Server, web page, embedded database and simulated rigs",
                               serve_options,
                               &server::Serve,
                               chosen);
  serve.add_option("--config", serve_options.config_path, "TOML file with settings");
  serve.add_option("--listen", serve_options.listen, "HOST:PORT, default 127.0.0.1:8080");
  serve.add_option("--data", serve_options.data_dir, "Folder of the database, default data");
  serve.add_option("--lcm", serve_options.lcm_url, "LCM bus: live tap and remote rigs, udpm://..");
  serve.add_option("--sim-rigs", serve_options.sim_rigs, "Number of simulated rigs");
  serve.add_option("--sim-speed", serve_options.sim_speed, "1 = real time; 20 = 20 s take 1 s");
  serve.add_option("--fixture-seed", serve_options.fixture_seed, "Seed of runs that name none");
  serve.add_option("--log-level", serve_options.log_level, "trace, debug, info, warn or error");
  serve.footer(
      "Examples:\n"
      "  faultlab serve                                  http://localhost:8080, data in ./data\n"
      "  faultlab serve --listen 127.0.0.1:9000 --data /var/lib/faultlab\n"
      "  faultlab serve --lcm 'udpm://239.255.76.67:7667?ttl=1'    then: lcm-logger, faultlab rig");

  server::SimulateOptions simulate_options;
  CLI::App& simulate = AddCommand(app,
                                  "simulate",
                                  "One run of the simulated bench into a CSV file",
                                  simulate_options,
                                  &server::RunSimulate,
                                  chosen);
  simulate.add_option("--fault",
                      simulate_options.faults,
                      "COMPONENT=VALUE@SECONDS, repeatable; @A..B drifts, @AtoB goes back");
  simulate.add_option("--profile", simulate_options.profile, "bench (friction, noise) or multisim")
      ->capture_default_str();
  simulate.add_option("--seed", simulate_options.seed, "Noise and excitation")
      ->capture_default_str();
  simulate.add_option("--duration", simulate_options.duration_s, "Seconds")->capture_default_str();
  simulate.add_option("--period", simulate_options.period_s, "Sample period in seconds")
      ->capture_default_str();
  simulate.add_option("--excitation", simulate_options.excitation, "Control voltage, see below")
      ->capture_default_str();
  simulate
      .add_option("-o,--output", simulate_options.output, "FILE.csv or FILE.csv.gz, - = stdout")
      ->required();
  simulate.footer(kSimulateExamples);

  server::DiagnoseCommandOptions diagnose_options;
  CLI::App& diagnose = AddCommand(app,
                                  "diagnose",
                                  "Which component failed, when, and its value with its error",
                                  diagnose_options,
                                  &server::RunDiagnose,
                                  chosen);
  diagnose
      .add_option("FILE", diagnose_options.files, "Recordings, .csv or .csv.gz, or folders of them")
      ->required();
  AddDiagnosisFlags(diagnose, diagnose_options.flags);
  diagnose.add_flag("--json", diagnose_options.json, "One JSON object a line and file");
  diagnose.footer(kDiagnoseExamples);

  server::CalibrateOptions calibrate_options;
  CLI::App& calibrate = AddCommand(app,
                                   "calibrate",
                                   "Learns a rig from a fault-free recording and stores it",
                                   calibrate_options,
                                   &server::RunCalibrate,
                                   chosen);
  calibrate.add_option("FILE", calibrate_options.recording, "Recording, .csv or .csv.gz")
      ->required();
  calibrate.add_option("-o,--output", calibrate_options.output, "FILE.json; '-' prints it");
  calibrate
      .add_option("--healthy", calibrate_options.flags.healthy, "Fault-free stretch in seconds")
      ->capture_default_str();
  calibrate.add_option("--channels", calibrate_options.flags.channels, "um or all")
      ->capture_default_str();
  calibrate
      .add_option(
          "--false-alarms", calibrate_options.false_alarms_per_day, "Of the detection, a day")
      ->capture_default_str();
  calibrate.add_option("--dated", calibrate_options.dated, "Date to store, default now");
  calibrate.footer(kCalibrateExamples);

  server::StudyCommandOptions study_options;
  CLI::App& study = AddCommand(app,
                               "study",
                               "Windows and data lengths over one recording, side by side",
                               study_options,
                               &server::RunStudy,
                               chosen);
  study.add_option("FILE", study_options.recording, "Recording, .csv or .csv.gz")->required();
  study.add_option("--k", study_options.windows, "Windows K of SWA, samples")
      ->capture_default_str();
  study.add_option("--km", study_options.integrals, "Windows K:m of SIA, samples")
      ->capture_default_str();
  study.add_option("--change", study_options.change, "Time of the fault: auto, none or seconds")
      ->capture_default_str();
  study.add_option("--from", study_options.from_s, "Start, behind the motor's start-up, seconds")
      ->capture_default_str();
  study.add_option("--order", study_options.order, "Of the model, 1 or 2")->capture_default_str();
  study.add_flag("--exact", study_options.exact, "SIA with the paper's integration rule undone");
  study.add_flag("--affine", study_options.affine, "A constant column against Coulomb friction");
  study.add_flag("--json", study_options.json, "One JSON object");
  study.add_option("--plots", study_options.plots_dir, "Folder for swa.png and sia.png");
  study.footer(kStudyExamples);

  server::PlotOptions plot_options;
  CLI::App& plot = AddCommand(
      app, "plot", "A figure of a recording as PNG", plot_options, &server::RunPlot, chosen);
  plot.add_option("RECORDING", plot_options.recording, "CSV file, or the id of a stored run")
      ->required();
  plot.add_option("--figure", plot_options.figure, "signals, swa, sia or models")
      ->capture_default_str();
  plot.add_option("-o,--output", plot_options.output, "FILE.png, or FILE.json for the data")
      ->required();
  plot.add_option("--scale", plot_options.scale, "1 = 1600 x 900 pixels, 2 = twice that")
      ->capture_default_str();
  plot.add_option("--data", plot_options.data_dir, "Folder of the server's database")
      ->capture_default_str();
  AddDiagnosisFlags(plot, plot_options.flags);
  plot.footer(kPlotExamples);

  server::ReproduceOptions reproduce_options;
  CLI::App& reproduce = AddCommand(app,
                                   "reproduce",
                                   "The paper's Tables 3-20 and Figures 14-23 beside ours",
                                   reproduce_options,
                                   &server::RunReproduce,
                                   chosen);
  reproduce.add_flag("--json", reproduce_options.json, "One JSON object instead of tables");
  reproduce.add_option("--plots", reproduce_options.plots_dir, "Folder for the figures as PNG");
  reproduce.add_option("--seed", reproduce_options.seed, "Noise")->capture_default_str();
  reproduce
      .add_option(
          "--repetitions", reproduce_options.repetitions, "Records a fault; the median is shown")
      ->capture_default_str();
  reproduce.footer(
      "Numbers marked * are errors of the paper; the note below the table says which.\n\n"
      "Examples:\n"
      "  faultlab reproduce | less\n"
      "  faultlab reproduce --json | jq .summary\n"
      "  faultlab reproduce --plots figures");

  server::IsolabilityCommandOptions isolability_options;
  CLI::App& isolability = AddCommand(app,
                                     "isolability",
                                     "Which faults of a set can be seen and told apart",
                                     isolability_options,
                                     &server::RunIsolability,
                                     chosen);
  isolability.add_option("--fault",
                         isolability_options.faults,
                         "COMPONENT=VALUE, repeatable; without it the paper's 18 faults");
  isolability.add_option("--channels", isolability_options.channels, "um or all")
      ->capture_default_str();
  isolability.add_option("--window", isolability_options.window_samples, "Samples of the fault")
      ->capture_default_str();
  isolability.add_option("--profile", isolability_options.profile, "bench or multisim")
      ->capture_default_str();
  isolability.add_option("--excitation", isolability_options.excitation, "As of simulate")
      ->capture_default_str();
  isolability.add_flag("--json", isolability_options.json, "One JSON object");
  isolability.add_option("-o,--output", isolability_options.output, "The matrix as FILE.png");
  isolability.footer(
      "From the model alone, no noise is simulated: distances between the records of two rigs.\n\n"
      "Examples:\n"
      "  faultlab isolability -o paper.png\n"
      "  faultlab isolability --channels all --window 25 --fault R1=10 --fault Ra=10 --json");

  hardware::RigAgentOptions rig_options;
  CLI::App& rig = AddCommand(app,
                             "rig",
                             "Agent beside a bench, or a simulated bench on another machine",
                             rig_options,
                             &hardware::RunRigAgent,
                             chosen);
  rig.add_option("--id", rig_options.id, "Name of the rig; default: the one in --config");
  rig.add_option(
      "--lcm", rig_options.lcm_url, "Bus to the server, udpm://239.255.76.67:7667?ttl=1");
  rig.add_option(
      "--config", rig_options.config_file, "Bench TOML; without it the bench is simulated");
  rig.add_option("--profile", rig_options.profile, "Of the simulated bench: bench or multisim")
      ->capture_default_str();
  rig.add_option("--speed", rig_options.speed, "Of the simulated bench")->capture_default_str();
  rig.add_option(
      "--keys", rig_options.key_directory, "Folder with ID.key, default ~/.faultlab/keys");
  rig.add_option("--ride-through",
                 rig_options.ride_through_s,
                 "Seconds that a run goes on when its server falls silent")
      ->capture_default_str();
  rig.add_flag("--self-test", rig_options.self_test, "Walk the relay positions, print, exit");
  rig.add_flag("--json", rig_options.json, "With --self-test: the report as JSON");
  rig.add_flag(
      "!--no-supervisor", rig_options.supervise, "No second process that guards the first");
  rig.footer(
      "Examples:\n"
      "  faultlab rig --id bench-1 --config bench.toml --lcm 'udpm://239.255.76.67:7667?ttl=1'\n"
      "  faultlab rig --id far-sim --profile multisim --lcm 'udpm://239.255.76.67:7667?ttl=1'\n"
      "  faultlab rig --id bench-1 --config bench.toml --self-test");

  CLI::App& lcm = *app.add_subcommand("lcm", "Recordings to and from logs of the LCM tools");
  lcm.require_subcommand(1);
  server::LcmExportOptions lcm_export;
  CLI::App& export_log = AddCommand(lcm,
                                    "export",
                                    "A recording as lcm-logger would have written it",
                                    lcm_export,
                                    &server::RunLcmExport,
                                    chosen);
  export_log.add_option("RECORDING", lcm_export.recording, "CSV file, or the id of a stored run")
      ->required();
  export_log.add_option("-o,--output", lcm_export.output, "LCM log to write")->required();
  export_log.add_option("--rig", lcm_export.rig, "Channel FAULTLAB.<rig>.SAMPLE")
      ->capture_default_str();
  export_log.add_option("--run", lcm_export.run, "Name of the run on the bus");
  export_log.add_option("--data", lcm_export.data_dir, "Folder of the server's database")
      ->capture_default_str();
  server::LcmImportOptions lcm_import;
  CLI::App& import_log = AddCommand(lcm,
                                    "import",
                                    "A run out of a log of lcm-logger, as CSV",
                                    lcm_import,
                                    &server::RunLcmImport,
                                    chosen);
  import_log.add_option("LOG", lcm_import.log, "File of lcm-logger")->required();
  import_log.add_option("-o,--output", lcm_import.output, "FILE.csv or FILE.csv.gz")->required();
  import_log.add_option("--run", lcm_import.run, "Which run; default the first in the log");
  lcm.footer(
      "Examples:\n"
      "  faultlab lcm export run.csv -o run.lcm && lcm-logplayer run.lcm\n"
      "  lcm-logger -f seen.lcm        while `faultlab serve --lcm URL` runs something\n"
      "  faultlab lcm import seen.lcm -o seen.csv && faultlab diagnose seen.csv");

  const AdminCommands admin(app, chosen);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked = error.get_exit_code() == EXIT_SUCCESS;  // --help, --version
    if (!asked && argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      server::PrintError("unknown command '" + std::string(argv[1]) + "'");
    }
    app.exit(error);
    return asked ? server::kExitOk : server::kExitBadInput;
  }
  try {
    return chosen();
  } catch (const std::exception& error) {
    server::PrintError(std::string("internal error: ") + error.what());
    return server::kExitFailure;
  }
}
