#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "server/cli/add_command.h"
#include "server/cli/commands.h"
#include "server/cli/isolability.h"
#include "server/cli/reproduce.h"

namespace faultlab::server {
namespace {

class ModelCommands {
 public:
  ModelCommands(CLI::App& app, std::function<int()>& chosen) {
    AddReproduce(app, chosen);
    AddIsolability(app, chosen);
  }

 private:
  void AddReproduce(CLI::App& app, std::function<int()>& chosen) {
    CLI::App& reproduce = AddCommand(app,
                                     "reproduce",
                                     "The paper's Tables 3-20 and Figures 14-23 beside ours",
                                     reproduce_,
                                     &RunReproduce,
                                     chosen);
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

  void AddIsolability(CLI::App& app, std::function<int()>& chosen) {
    CLI::App& isolability = AddCommand(app,
                                       "isolability",
                                       "Which faults of a set can be seen and told apart",
                                       isolability_,
                                       &RunIsolability,
                                       chosen);
    IsolabilityQuestion& asked = isolability_.question;
    isolability.add_option("--fault",
                           isolability_.faults,
                           "COMPONENT=VALUE, repeatable; without it the paper's 18 faults");
    isolability.add_option("--channels", asked.channels, "um or all")->capture_default_str();
    isolability.add_option("--window", asked.window_samples, "Samples of the fault")
        ->capture_default_str();
    isolability.add_option("--profile", asked.profile, "bench or multisim")->capture_default_str();
    isolability.add_option("--calibration",
                           isolability_.calibration,
                           "FILE.json of 'faultlab calibrate': this rig, not a profile");
    isolability.add_option("--um-noise", asked.um_noise_v, "Volt, instead of the rig's own");
    isolability.add_option("--excitation", isolability_.excitation, "As of simulate")
        ->capture_default_str();
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

  ReproduceOptions reproduce_;
  IsolabilityCommandOptions isolability_;
};

}  // namespace

CommandGroup AddModelCommands(CLI::App& app, std::function<int()>& chosen) {
  return std::make_shared<const ModelCommands>(app, chosen);
}

}  // namespace faultlab::server
