#include <CLI/CLI.hpp>
#include <memory>

#include "server/cli/add_command.h"
#include "server/cli/bench_option.h"
#include "server/cli/calibrate.h"
#include "server/cli/commands.h"
#include "server/cli/diagnose.h"
#include "server/cli/plot.h"
#include "server/cli/simulate.h"
#include "server/cli/study.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {
namespace {

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
    "Columns written: t_s, uc_v, um_v, ua_v (V), ia_a (A), n_rpm (behind the gear).";

constexpr char kDiagnoseExamples[] =
    "Input: CSV with a header of t_s,uc_v,um_v and any of ua_v,ia_a,n_rpm, in any order. Other\n"
    "names and units are read too: 't [ms]', 'Uc (V)', 'um_mV', 'speed_rpm', 'time'. Cells "
    "between\n"
    "commas, semicolons, tabs or '|'; decimal commas with all but commas. '#' begins a comment,\n"
    ".gz is read through gzip, '-' is the standard input. An empty cell or NaN is a lost reading; "
    "missing\n"
    "rows are gaps. What was understood beyond the plain names is said on stderr.\n\n"
    "Examples:\n"
    "  faultlab diagnose run.csv                       learns the rig between 0.5 s and 5 s\n"
    "  faultlab diagnose --healthy 1:9 a.csv b.csv.gz  a longer fault-free stretch\n"
    "  faultlab diagnose --calibration rig.json x.csv  the rig as 'faultlab calibrate' stored it\n"
    "  faultlab diagnose --channels um run.csv         as the paper: voltage alone\n"
    "  faultlab diagnose --values table2 run.csv       faults are values that the relays connect\n"
    "  faultlab diagnose --json runs/ | jq .verdict    every recording of a folder\n\n"
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
    "sooner, a long one spreads less; an input too poor for a window shows as not excited. Of "
    "several\n"
    "orders also what each leaves, whether that is white, and which is worth its parameters "
    "(BIC).\n\n"
    "Examples:\n"
    "  faultlab study run.csv                            the paper's six windows\n"
    "  faultlab study run.csv --k 25,50,400 --km \"\"       SWA alone\n"
    "  faultlab study run.csv --km 100:5,100:20,100:50 --k \"\" --exact --plots figures\n"
    "  faultlab study run.csv --k 100 --km 100:20 --order 1,2,3,4\n"
    "  faultlab study run.csv --change 10 --json | jq .variants";

constexpr char kPlotExamples[] =
    "Figures: signals (Uc, Um, Ia, n), swa and sia (estimates with their windows), models "
    "(measured\n"
    "Um beside simulated models, fit in percent), friction (over speed), steps and decisions (of\n"
    "the paper, and the way of this verdict), curves (of several recordings, one curve a value).\n"
    "A name that ends in .json gets the figure's data.\n\n"
    "Examples:\n"
    "  faultlab plot run.csv --figure sia -o sia.png\n"
    "  faultlab plot run.csv.gz --figure models --scale 2 -o print.png\n"
    "  faultlab plot r1.csv r10.csv r56.csv --figure curves -o curves.png\n"
    "  faultlab plot RUN-ID --data data --figure signals -o run.png";

void AddDiagnosisFlags(CLI::App& command, DiagnosisFlags& flags) {
  AddBench(command, flags.bench);
  command.add_option(
      "--healthy",
      flags.healthy,
      "Fault-free stretch FROM:TO in seconds; default: 0.5:5, longer for slow benches");
  command.add_option("--channels", flags.channels, "Channels to use: um or all")
      ->capture_default_str();
  command
      .add_option("--values",
                  flags.values,
                  "table2: a fault has a value that the bench lists; none: any value")
      ->capture_default_str();
  command.add_option("--calibration",
                     flags.calibration,
                     "FILE.json of 'faultlab calibrate', in place of the record's own start");
}

class RecordCommands : Commands {
 public:
  RecordCommands(CLI::App& app, std::function<int()>& chosen) : Commands(chosen) {
    AddSimulate(app);
    AddDiagnose(app);
    AddCalibrate(app);
    AddStudy(app);
    AddPlot(app);
  }

 private:
  void AddSimulate(CLI::App& app) {
    CLI::App& simulate = Add(
        app, "simulate", "One run of the simulated bench into a CSV file", simulate_, &RunSimulate);
    AddBench(simulate, simulate_.bench);
    simulate.add_option("--fault",
                        simulate_.faults,
                        "COMPONENT=VALUE@SECONDS, repeatable; @A..B drifts, @AtoB goes back");
    simulate.add_option("--profile",
                        simulate_.profile,
                        "A simulator of the bench, default its first; of the paper's: bench "
                        "(friction, noise) or multisim");
    simulate.add_option("--seed", simulate_.seed, "Noise and excitation")->capture_default_str();
    simulate.add_option("--duration", simulate_.duration_s, "Seconds")->capture_default_str();
    simulate.add_option(
        "--period", simulate_.period_s, "Sample period in seconds, default the bench's");
    simulate.add_option(
        "--excitation", simulate_.excitation, "Control voltage, see below; default the bench's");
    simulate.add_option("-o,--output", simulate_.output, "FILE.csv or FILE.csv.gz, - = stdout")
        ->required();
    simulate.footer(kSimulateExamples);
  }

  void AddDiagnose(CLI::App& app) {
    CLI::App& diagnose = Add(app,
                             "diagnose",
                             "Which component failed, when, and its value with its error",
                             diagnose_,
                             &RunDiagnose);
    diagnose.add_option("FILE", diagnose_.files, "Recordings, .csv or .csv.gz, or folders of them")
        ->required();
    AddDiagnosisFlags(diagnose, diagnose_.flags);
    diagnose.add_flag("--json", diagnose_.json, "One JSON object a line and file");
    diagnose.add_option("--method",
                        diagnose_.method,
                        "A method of 'faultlab methods' in place of faultlab's own: ls, rls, "
                        "ekf-bank, ..");
    diagnose.footer(kDiagnoseExamples);
  }

  void AddCalibrate(CLI::App& app) {
    CLI::App& calibrate = Add(app,
                              "calibrate",
                              "Learns a rig from a fault-free recording and stores it",
                              calibrate_,
                              &RunCalibrate);
    calibrate.add_option("FILE", calibrate_.recording, "Recording, .csv or .csv.gz")->required();
    AddBench(calibrate, calibrate_.flags.bench);
    calibrate.add_option("-o,--output", calibrate_.output, "FILE.json; '-' prints it");
    calibrate.add_option("--healthy",
                         calibrate_.flags.healthy,
                         "Fault-free stretch FROM:TO in seconds; default: 0.5:5, longer for slow "
                         "benches");
    calibrate.add_option("--channels", calibrate_.flags.channels, "um or all")
        ->capture_default_str();
    calibrate
        .add_option("--false-alarms", calibrate_.false_alarms_per_day, "Of the detection, a day")
        ->capture_default_str();
    calibrate.add_option("--dated", calibrate_.dated, "Date to store, default now");
    calibrate.footer(kCalibrateExamples);
  }

  void AddStudy(CLI::App& app) {
    CLI::App& study = Add(app,
                          "study",
                          "Windows and data lengths over one recording, side by side",
                          study_,
                          &RunStudy);
    study.add_option("FILE", study_.recording, "Recording, .csv or .csv.gz")->required();
    AddBench(study, study_.bench);
    study.add_option("--k", study_.asked.windows, "Windows K of SWA, samples")
        ->capture_default_str();
    study.add_option("--km", study_.asked.integrals, "Windows K:m of SIA, samples")
        ->capture_default_str();
    study.add_option("--change", study_.asked.change, "Time of the fault: auto, none or seconds")
        ->capture_default_str();
    study.add_option("--from", study_.asked.from_s, "Start, behind the motor's start-up, seconds")
        ->capture_default_str();
    study.add_option("--order", study_.asked.orders, "Of the model, 1 to 4; several: 1,2,3")
        ->capture_default_str();
    study.add_flag("--exact", study_.asked.exact, "SIA with the paper's integration rule undone");
    study.add_flag("--affine", study_.asked.affine, "A constant column against Coulomb friction");
    study.add_flag("--json", study_.json, "One JSON object");
    study.add_option("--plots", study_.plots_dir, "Folder for swa.png and sia.png");
    study.footer(kStudyExamples);
  }

  void AddPlot(CLI::App& app) {
    CLI::App& plot = Add(app, "plot", "A figure of a recording as PNG", plot_, &RunPlot);
    plot.add_option("RECORDING",
                    plot_.recordings,
                    "CSV file, or the id of a stored run; several for curves")
        ->required();
    plot.add_option("--figure", plot_.figure, FigureList() + ", curves")->capture_default_str();
    plot.add_option("-o,--output", plot_.output, "FILE.png, or FILE.json for the data")->required();
    plot.add_option("--scale", plot_.scale, "1 = 1600 x 900 pixels, 2 = twice that")
        ->capture_default_str();
    plot.add_option("--data", plot_.data_dir, "Folder of the server's database")
        ->capture_default_str();
    AddDiagnosisFlags(plot, plot_.flags);
    plot.footer(kPlotExamples);
  }

  SimulateOptions simulate_;
  DiagnoseCommandOptions diagnose_;
  CalibrateOptions calibrate_;
  StudyCommandOptions study_;
  PlotOptions plot_;
};

}  // namespace

CommandGroup AddRecordCommands(CLI::App& app, std::function<int()>& chosen) {
  return std::make_shared<const RecordCommands>(app, chosen);
}

}  // namespace faultlab::server
