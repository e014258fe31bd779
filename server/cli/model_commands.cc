#include <CLI/CLI.hpp>
#include <memory>

#include "server/cli/add_command.h"
#include "server/cli/bench_check.h"
#include "server/cli/bench_new.h"
#include "server/cli/bench_option.h"
#include "server/cli/commands.h"
#include "server/cli/control.h"
#include "server/cli/isolability.h"
#include "server/cli/methods.h"
#include "server/cli/reproduce.h"

namespace faultlab::server {
namespace {

class ModelCommands : Commands {
 public:
  ModelCommands(CLI::App& app, std::function<int()>& chosen) : Commands(chosen) {
    AddReproduce(app);
    AddIsolability(app);
    AddMethods(app);
    AddBenches(app);
    AddControl(app);
  }

 private:
  void AddReproduce(CLI::App& app) {
    CLI::App& reproduce = Add(app,
                              "reproduce",
                              "The paper's Tables 3-20 and Figures 4, 6 and 14-23 beside ours",
                              reproduce_,
                              &RunReproduce);
    AddBench(reproduce, reproduce_.bench);
    reproduce.add_flag("--json", reproduce_.json, "One JSON object instead of tables");
    reproduce.add_option("--plots", reproduce_.plots_dir, "Folder for the figures as PNG");
    reproduce.add_option("--seed", reproduce_.seed, "Noise")->capture_default_str();
    reproduce
        .add_option("--repetitions", reproduce_.repetitions, "Records a fault; the median is shown")
        ->capture_default_str();
    reproduce.footer(
        "Numbers marked * are errors of the paper; the note below the table says which.\n\n"
        "Examples:\n"
        "  faultlab reproduce | less\n"
        "  faultlab reproduce --json | jq .summary\n"
        "  faultlab reproduce --plots figures");
  }

  void AddIsolability(CLI::App& app) {
    CLI::App& isolability = Add(app,
                                "isolability",
                                "Which faults of a set can be seen and told apart",
                                isolability_,
                                &RunIsolability);
    IsolabilityQuestion& asked = isolability_.question;
    AddBench(isolability, isolability_.bench);
    isolability.add_option("--fault",
                           isolability_.faults,
                           "COMPONENT=VALUE, repeatable; without it those of the bench");
    isolability.add_option(
        "--channels", asked.channels, "um or all; default um, where the estimators use it");
    isolability.add_option("--window", asked.window_samples, "Samples of the fault")
        ->capture_default_str();
    isolability.add_option(
        "--profile", asked.profile, "A simulator of the bench, default its first");
    isolability.add_option("--calibration",
                           isolability_.calibration,
                           "FILE.json of 'faultlab calibrate': this rig, not a profile");
    isolability.add_option("--um-noise", asked.um_noise_v, "Volt, instead of the rig's own");
    isolability.add_option(
        "--excitation", isolability_.excitation, "As of simulate, default the bench's");
    isolability.add_flag("--json", isolability_.json, "One JSON object");
    isolability.add_option("-o,--output", isolability_.output, "The matrix as FILE.png");
    isolability.footer(
        "From the model alone, no noise is simulated: distances between the records of two "
        "rigs.\n\n"
        "Examples:\n"
        "  faultlab isolability -o paper.png\n"
        "  faultlab isolability --channels all --window 25 --fault R1=10 --fault Ra=10 --json\n"
        "  faultlab isolability --calibration rig.json --um-noise 0.03");
  }

  void AddMethods(CLI::App& app) {
    CLI::App& methods = Add(app,
                            "methods",
                            "Every method of the literature on the same records",
                            methods_,
                            &RunMethods);
    AddBench(methods, methods_.bench);
    methods.add_option("--method", methods_.methods, "NAME, repeatable; without it all");
    methods.add_option(
        "--channels", methods_.channels, "um or all; default um, where the estimators use it");
    methods.add_option("--recordings",
                       methods_.recordings,
                       "Folder of recordings, with their faults in comments or in manifest.json; "
                       "without it simulated runs");
    methods.add_option("--trials", methods_.trials, "Simulated records of each fault")
        ->capture_default_str();
    methods.add_option("--hours", methods_.hours, "Healthy simulated hours of each method")
        ->capture_default_str();
    methods.add_option("--seed", methods_.seed, "Of the first record")->capture_default_str();
    methods.add_flag("--json", methods_.json, "One JSON object");
    methods.add_option("--markdown", methods_.markdown, "FILE.md: Table 21 with figures");
    methods.add_flag("--append", methods_.append, "Keeps what FILE.md has, and adds this table");
    methods.add_option("--plots", methods_.plots_dir, "Folder for methods.png");
    methods.footer(
        "Examples:\n"
        "  faultlab methods --trials 2 --hours 0.5\n"
        "  faultlab methods --method rls --method ekf-bank --json | jq .methods\n"
        "  faultlab methods --recordings records --markdown table.md --plots figures");
  }

  void AddControl(CLI::App& app) {
    CLI::App& control = Add(app,
                            "control",
                            "Keeps the speed of a simulated rig although a part fails",
                            control_,
                            &RunControlCommand);
    AddBench(control, control_.bench);
    control.add_option("--fault", control_.faults, "COMPONENT=VALUE@SECONDS, repeatable");
    control.add_option("--told",
                       control_.told,
                       "COMPONENT=VALUE@SECONDS: the control hears this instead of the diagnosis");
    control.add_option("--reference", control_.reference, "LOW:HIGH in rad/s of the motor shaft")
        ->capture_default_str();
    control.add_option("--shape", control_.shape, "steps, ramp or prbs: how it goes between them")
        ->capture_default_str();
    control.add_option("--hold", control_.hold_s, "Seconds at one speed, or of one ramp")
        ->capture_default_str();
    control.add_option("--controller", control_.controller, "nominal, compensated or robust")
        ->capture_default_str();
    control.add_option("--duration", control_.duration_s, "Seconds")->capture_default_str();
    control.add_option("--seed", control_.seed, "Noise")->capture_default_str();
    control.add_flag("--json", control_.json, "One JSON object");
    control.add_option("--markdown", control_.markdown, "FILE.md: all faults of the bench");
    control.footer(
        "The first seconds learn the healthy rig under the bench's usual input.\n\n"
        "Examples:\n"
        "  faultlab control --fault R1=100@10\n"
        "  faultlab control --fault R1=100@10 --controller nominal --json\n"
        "  faultlab control --markdown control.md");
  }

  void AddBenches(CLI::App& app) {
    CLI::App& bench = *app.add_subcommand("bench", "Describes a bench, and says what it can tell");
    bench.require_subcommand(1);
    CLI::App& check = Add(bench,
                          "check",
                          "Is the description sound, and what can be diagnosed on it",
                          check_,
                          &RunBenchCheck);
    check.add_option("FILE", check_.bench, "Description, FILE.toml")->required();
    check.add_option("--channels", check_.channels, "all or um")->capture_default_str();
    check.footer(
        "Refusals name file, line and key. The answer comes from the model alone, before anything "
        "is built.\n\n"
        "Examples:\n"
        "  faultlab bench new --structure motor-driver -o mine.toml\n"
        "  faultlab bench check mine.toml\n"
        "  faultlab simulate --bench mine.toml --fault J=2e-5@10 -o run.csv\n"
        "  faultlab diagnose --bench mine.toml run.csv");
    CLI::App& fresh =
        Add(bench, "new", "A commented description to start from", new_, &RunBenchNew);
    fresh.add_option("--structure", new_.structure, StructureNames())->capture_default_str();
    fresh.add_option("-o,--output", new_.output, "FILE.toml, - = stdout")->capture_default_str();
  }

  ControlCommandOptions control_;
  BenchCheckOptions check_;
  BenchNewOptions new_;
  ReproduceOptions reproduce_;
  IsolabilityCommandOptions isolability_;
  MethodsCommandOptions methods_;
};

}  // namespace

CommandGroup AddModelCommands(CLI::App& app, std::function<int()>& chosen) {
  return std::make_shared<const ModelCommands>(app, chosen);
}

}  // namespace faultlab::server
