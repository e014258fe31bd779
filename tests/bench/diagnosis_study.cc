// A seeded Monte Carlo study of the diagnosis: false alarms on healthy rigs, and per fault the
// delay of detection, the rate of right isolation and the error of identification.
//   diagnosis_study [--hours H] [--rig-minutes M] [--trials N] [--robust-trials N] [--seed S] [--verbose] [-o FILE]
// Writes markdown. Every number is a simulation of core's plant, judged by core's pipeline as a
// live run would use it, with no list of possible values; the same seed gives the same table.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/isolability.h"
#include "core/diagnosis/pipeline.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "core/signals/random.h"
#include "tests/bench/study_statistics.h"

namespace faultlab::study {
namespace {

using namespace core;

struct Settings {
  double hours = 48.0;
  double rig_minutes = 15.0;  ///< of healthy record of one rig
  int trials = 20;
  int robust_trials = 4;
  std::uint64_t seed = 1;
  bool verbose = false;
  const char* output = nullptr;
};

/// One circumstance under which faults are tried.
struct Case {
  const char* name;
  double um_noise_v = 0.015;
  double clock_s = 0.01;
  double tolerance = 0.0;  ///< each component of the real rig is off its data sheet by up to this
  bool um_only = false;
  double at_from_s = 8.0;
  double at_to_s = 12.0;
};

struct Outcome {
  bool calibrated = false;
  bool false_alarm = false;  ///< before the fault
  double delay_samples = std::numeric_limits<double>::infinity();
  bool isolated_1s = false;
  bool isolated = false;  ///< at the end of the record
  bool bound = false;     ///< only a bound was given, and it holds
  double error = std::numeric_limits<double>::quiet_NaN();  ///< relative, of the true component
};

/// The components that a fault cannot be told from with these channels in one second, itself first:
/// what the isolability analysis computes from the model for a healthy rig.
std::vector<Component> Indistinguishable(const FaultSize& fault, bool um_only) {
  IsolabilityOptions options;
  options.rig.mc_nm = BenchProfileBench().friction.mc_nm;
  options.rig.delta_s = BenchProfileBench().delta_s;
  options.channels = um_only ? Channels::kUmOnly : Channels::kAll;
  options.uc_v = MakePrbs(PrbsSpec{}, 300, kSamplePeriodSeconds);
  options.faults = {fault};
  return AnalyseIsolability(options).value().faults.front().group;
}

/// A fault, its component or the component with some of those that nothing separates it from.
bool NamesIt(const Verdict& verdict, const std::vector<Component>& allowed) {
  if (verdict.kind != VerdictKind::kFault) {
    return false;
  }
  bool found = false;
  for (Component member : verdict.group) {
    found |= member == allowed.front();
    if (std::find(allowed.begin(), allowed.end(), member) == allowed.end()) {
      return false;
    }
  }
  return found;
}

void SolveTasks(Pipeline& pipeline) {
  while (std::optional<IsolationTask> task = pipeline.TakeTask()) {
    pipeline.Accept(Solve(*task));
  }
}

PlantParameters DrawRig(double tolerance, Random& random) {
  PlantParameters rig;
  for (Component component : kAllComponents) {
    rig.Set(component, rig.Get(component) * (1.0 + tolerance * random.Uniform(-1.0, 1.0)));
  }
  return rig;
}

std::string Describe(const Verdict& verdict) {
  std::string text(Name(verdict.kind));
  for (Component member : verdict.group) {
    text += " [" + std::string(Name(member)) + "]";
  }
  for (const Candidate& candidate : verdict.candidates) {
    char buffer[96];
    std::snprintf(buffer,
                  sizeof buffer,
                  " %s%c%.4g+-%.2g(score %.3g)",
                  std::string(Name(candidate.component)).c_str(),
                  candidate.bound != 0 ? candidate.bound : '=',
                  candidate.value,
                  candidate.sigma,
                  candidate.score);
    text += buffer;
  }
  return text;
}

Outcome RunTrial(const Case& setting,
                 const FaultSize& size,
                 std::uint64_t seed,
                 bool relative_value,
                 bool verbose) {
  Random random(StreamSeed(seed, 7));
  const PlantParameters rig = DrawRig(setting.tolerance, random);
  BenchProfile profile = BenchProfileBench();
  profile.noise.um_v = setting.um_noise_v;
  Fault fault;
  fault.component = size.component;
  fault.value = relative_value ? size.value * rig.Get(size.component) : size.value;
  fault.at_s = random.Uniform(setting.at_from_s, setting.at_to_s);
  PrbsSpec prbs;
  prbs.clock_s = setting.clock_s;
  prbs.seed = 1 + random.Below(1000);
  constexpr int kSamples = 2000;
  const std::vector<double> uc_v = MakePrbs(prbs, kSamples, kSamplePeriodSeconds);
  const std::vector<Sample> samples =
      SimulateRecord(profile, rig, uc_v, std::span<const Fault>(&fault, 1), seed);

  const std::vector<Component> allowed =
      Indistinguishable({fault.component, fault.value}, setting.um_only);
  PipelineConfig config;
  config.channels = setting.um_only ? Channels::kUmOnly : Channels::kAll;
  Pipeline pipeline(config);
  Outcome outcome;
  std::string at_1s;
  for (const Sample& sample : samples) {
    pipeline.Push(sample);
    SolveTasks(pipeline);
    const Verdict& verdict = pipeline.verdict();
    if (sample.t_s < fault.at_s) {
      outcome.false_alarm |= verdict.detected_at_s.has_value();
      continue;
    }
    if (verdict.detected_at_s && !(outcome.delay_samples < 1e9)) {
      outcome.delay_samples =
          1.0 + std::floor((*verdict.detected_at_s - fault.at_s) / kSamplePeriodSeconds + 1e-6);
    }
    if (sample.t_s < fault.at_s + 1.0) {
      outcome.isolated_1s = NamesIt(verdict, allowed);
      at_1s = verbose ? Describe(verdict) : "";
    }
  }
  const Diagnosis diagnosis = pipeline.Finish();
  outcome.calibrated = diagnosis.calibration.has_value();
  outcome.isolated = NamesIt(diagnosis.verdict, allowed);
  for (const Candidate& candidate : diagnosis.verdict.candidates) {
    if (candidate.component != fault.component) {
      continue;
    }
    if (candidate.bound != 0) {
      outcome.bound =
          candidate.bound == '<' ? fault.value < candidate.value : fault.value > candidate.value;
    } else {
      outcome.error = std::abs(candidate.value - fault.value) / fault.value;
    }
  }
  constexpr double kLargeError = 0.1;
  if (verbose && (!outcome.isolated || !outcome.isolated_1s || outcome.false_alarm ||
                  outcome.error > kLargeError)) {
    std::fprintf(stderr,
                 "%s%s %s=%.4g@%.2f seed %llu: delay %.0f false_alarm %d\n   1 s: %s\n   end: %s\n",
                 setting.name,
                 setting.um_only ? " (um)" : "",
                 std::string(Name(fault.component)).c_str(),
                 fault.value,
                 fault.at_s,
                 static_cast<unsigned long long>(seed),
                 outcome.delay_samples,
                 outcome.false_alarm ? 1 : 0,
                 at_1s.c_str(),
                 Describe(diagnosis.verdict).c_str());
  }
  return outcome;
}

/// Healthy rigs, an hour each, every one calibrated on its own first seconds.
struct AlarmCount {
  double hours = 0.0;
  int alarms = 0;
  int refused = 0;  ///< rigs whose calibration was refused
};

AlarmCount CountFalseAlarms(const Settings& settings, bool um_only) {
  AlarmCount count;
  const int samples_per_rig = static_cast<int>(settings.rig_minutes * 60.0 * kSampleRateHz);
  for (int run = 0; count.hours < settings.hours; ++run) {
    const std::uint64_t seed = StreamSeed(settings.seed, 1000 + static_cast<std::uint64_t>(run));
    Random random(StreamSeed(seed, 7));
    const PlantParameters rig = DrawRig(0.05, random);
    PrbsSpec prbs;
    prbs.order = 16;
    prbs.seed = 1 + random.Below(1000);
    const std::vector<double> uc_v = MakePrbs(prbs, samples_per_rig, kSamplePeriodSeconds);
    const std::vector<Sample> samples = SimulateRecord(BenchProfileBench(), rig, uc_v, {}, seed);
    PipelineConfig config;
    config.channels = um_only ? Channels::kUmOnly : Channels::kAll;
    Pipeline pipeline(config);
    std::optional<double> last;
    for (const Sample& sample : samples) {
      pipeline.Push(sample);
      SolveTasks(pipeline);
      const std::optional<double> detected = pipeline.verdict().detected_at_s;
      if (detected && detected != last) {
        ++count.alarms;
        last = detected;
        if (settings.verbose) {
          std::fprintf(stderr,
                       "false alarm%s: rig %d seed %llu t %.2f by %s: %s\n",
                       um_only ? " (um)" : "",
                       run,
                       static_cast<unsigned long long>(seed),
                       *detected,
                       pipeline.verdict().detector.c_str(),
                       Describe(pipeline.verdict()).c_str());
        }
      }
    }
    count.refused += pipeline.calibration() == nullptr;
    count.hours += settings.rig_minutes / 60.0;
  }
  return count;
}

struct Tally {
  int trials = 0;
  int detected = 0;
  int early = 0;  ///< false alarms before the fault
  int isolated_1s = 0;
  int isolated = 0;
  int bounds = 0;
  std::vector<double> delays;
  std::vector<double> errors;

  void Add(const Outcome& outcome) {
    ++trials;
    detected += outcome.delay_samples < 1e9;
    early += outcome.false_alarm;
    isolated_1s += outcome.isolated_1s;
    isolated += outcome.isolated;
    delays.push_back(outcome.delay_samples);
    if (outcome.bound) {
      ++bounds;
    } else if (outcome.isolated && std::isfinite(outcome.error)) {
      errors.push_back(outcome.error);
    }
  }
};

std::string Percent(double share) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.2f %%", 100.0 * share);
  return buffer;
}

std::string Rate(int hits, int trials) {
  const Interval interval = WilsonInterval(hits, trials);
  char buffer[64];
  std::snprintf(buffer,
                sizeof buffer,
                "%d/%d (%.0f-%.0f %%)",
                hits,
                trials,
                100.0 * interval.low,
                100.0 * interval.high);
  return buffer;
}

std::string Samples(double delay) {
  return std::isfinite(delay) ? std::to_string(static_cast<int>(delay)) : std::string("-");
}

std::string Errors(const Tally& tally) {
  if (tally.errors.empty()) {
    return tally.bounds > 0 ? "bound holds, " + std::to_string(tally.bounds) + "x"
                            : std::string("-");
  }
  return Percent(Quantile(tally.errors, 0.5)) + " / " + Percent(Quantile(tally.errors, 1.0));
}

std::string FaultName(const FaultSize& fault, bool relative_value) {
  char buffer[64];
  std::snprintf(buffer,
                sizeof buffer,
                relative_value ? "%s x %.2g" : "%s %.3g",
                std::string(Name(fault.component)).c_str(),
                fault.value);
  return relative_value ? std::string(buffer)
                        : std::string(buffer) + " " + std::string(Unit(fault.component));
}

void PrintFaultTable(std::FILE* out,
                     const Settings& settings,
                     std::span<const FaultSize> faults,
                     bool relative_value) {
  std::fprintf(out,
               "| fault | delay um, median / 95 %% | delay um+ia+n | isolated after 1 s, um | "
               "um+ia+n | at the end, um | um+ia+n | error um, median / worst | um+ia+n |\n"
               "|---|---|---|---|---|---|---|---|---|\n");
  std::array<Tally, 2> total;
  for (const FaultSize& fault : faults) {
    std::array<Tally, 2> tally;
    for (int channels = 0; channels < 2; ++channels) {
      const auto c = static_cast<std::size_t>(channels);
      Case setting{"nominal"};
      setting.um_only = channels == 0;
      for (int trial = 0; trial < settings.trials; ++trial) {
        const std::uint64_t seed = StreamSeed(settings.seed, static_cast<std::uint64_t>(trial));
        const Outcome outcome = RunTrial(setting, fault, seed, relative_value, settings.verbose);
        tally[c].Add(outcome);
        total[c].Add(outcome);
      }
    }
    std::fprintf(out,
                 "| %s | %s / %s | %s / %s | %s | %s | %s | %s | %s | %s |\n",
                 FaultName(fault, relative_value).c_str(),
                 Samples(Quantile(tally[0].delays, 0.5)).c_str(),
                 Samples(Quantile(tally[0].delays, 0.95)).c_str(),
                 Samples(Quantile(tally[1].delays, 0.5)).c_str(),
                 Samples(Quantile(tally[1].delays, 0.95)).c_str(),
                 Rate(tally[0].isolated_1s, tally[0].trials).c_str(),
                 Rate(tally[1].isolated_1s, tally[1].trials).c_str(),
                 Rate(tally[0].isolated, tally[0].trials).c_str(),
                 Rate(tally[1].isolated, tally[1].trials).c_str(),
                 Errors(tally[0]).c_str(),
                 Errors(tally[1]).c_str());
    std::fflush(out);
  }
  std::fprintf(out,
               "| **all** | %s / %s | %s / %s | %s | %s | %s | %s | %s | %s |\n\n",
               Samples(Quantile(total[0].delays, 0.5)).c_str(),
               Samples(Quantile(total[0].delays, 0.95)).c_str(),
               Samples(Quantile(total[1].delays, 0.5)).c_str(),
               Samples(Quantile(total[1].delays, 0.95)).c_str(),
               Rate(total[0].isolated_1s, total[0].trials).c_str(),
               Rate(total[1].isolated_1s, total[1].trials).c_str(),
               Rate(total[0].isolated, total[0].trials).c_str(),
               Rate(total[1].isolated, total[1].trials).c_str(),
               Errors(total[0]).c_str(),
               Errors(total[1]).c_str());
}

void PrintRobustness(std::FILE* out, const Settings& settings) {
  std::vector<Case> cases;
  for (const bool um_only : {true, false}) {
    cases.push_back({.name = "as above", .um_only = um_only});
    cases.push_back(
        {.name = "rig off its data sheet by +-5 %", .tolerance = 0.05, .um_only = um_only});
    cases.push_back({.name = "30 mV noise", .um_noise_v = 0.03, .um_only = um_only});
    cases.push_back({.name = "PRBS clock 20 ms", .clock_s = 0.02, .um_only = um_only});
    cases.push_back({.name = "PRBS clock 50 ms", .clock_s = 0.05, .um_only = um_only});
    cases.push_back(
        {.name = "fault at 5.5 .. 18 s", .um_only = um_only, .at_from_s = 5.5, .at_to_s = 18.0});
  }
  std::fprintf(out,
               "| case, all 18 faults | channels | alarm before the fault | detected | "
               "isolated after 1 s | at the end | error, median / worst |\n"
               "|---|---|---|---|---|---|---|\n");
  const auto row = [&](const Case& setting, std::span<const FaultSize> faults) {
    Tally tally;
    for (const FaultSize& fault : faults) {
      for (int trial = 0; trial < settings.robust_trials; ++trial) {
        const std::uint64_t seed =
            StreamSeed(settings.seed, 5000 + static_cast<std::uint64_t>(trial));
        tally.Add(RunTrial(setting, fault, seed, false, settings.verbose));
      }
    }
    std::fprintf(out,
                 "| %s | %s | %s | %s | %s | %s | %s |\n",
                 setting.name,
                 setting.um_only ? "um" : "um+ia+n",
                 Rate(tally.early, tally.trials).c_str(),
                 Rate(tally.detected, tally.trials).c_str(),
                 Rate(tally.isolated_1s, tally.trials).c_str(),
                 Rate(tally.isolated, tally.trials).c_str(),
                 Errors(tally).c_str());
    std::fflush(out);
  };
  for (const Case& setting : cases) {
    row(setting, PaperFaultSizes());
  }
  // Gains that drive um beyond the converter's +-10 V at the upper level of the input.
  const std::vector<FaultSize> clipping = {{Component::kR12, 18e3}, {Component::kR9, 5e3}};
  for (const bool um_only : {true, false}) {
    row({.name = "um clipped at the rail (R12 18 k, R9 5 k)", .um_only = um_only}, clipping);
  }
}

int Run(const Settings& settings) {
  std::FILE* out = settings.output != nullptr ? std::fopen(settings.output, "w") : stdout;
  if (out == nullptr) {
    std::fprintf(stderr, "cannot write %s\n", settings.output);
    return 2;
  }
  std::fprintf(out,
               "Bench profile, 15 mV noise, PRBS 2 V / 3 V at 10 ms, seed %llu, %d trials a fault, "
               "fault at 8 .. 12 s,\ncalibrated on each record's own 0.5 .. 5 s, no list of "
               "values. In brackets 95 %% intervals.\n\n",
               static_cast<unsigned long long>(settings.seed),
               settings.trials);
  if (settings.hours > 0.0) {
    std::fprintf(
        out, "| healthy rigs, each +-5 %% off its data sheet | um | um+ia+n |\n|---|---|---|\n");
    std::array<std::string, 2> cell;
    for (int channels = 0; channels < 2; ++channels) {
      const AlarmCount count = CountFalseAlarms(settings, channels == 0);
      const Interval interval = PoissonInterval(count.alarms);
      char buffer[128];
      std::snprintf(buffer,
                    sizeof buffer,
                    "%d in %.0f h: %.2f (%.2f-%.2f) per 24 h; refused %d",
                    count.alarms,
                    count.hours,
                    count.alarms / count.hours * 24.0,
                    interval.low / count.hours * 24.0,
                    interval.high / count.hours * 24.0,
                    count.refused);
      cell[static_cast<std::size_t>(channels)] = buffer;
    }
    std::fprintf(out,
                 "| false alarms (stated: 1 per 24 h) | %s | %s |\n\n",
                 cell[0].c_str(),
                 cell[1].c_str());
    std::fflush(out);
  }
  if (settings.trials > 0) {
    PrintFaultTable(out, settings, PaperFaultSizes(), false);
    const std::vector<FaultSize> small = {{Component::kR1, 1.3},
                                          {Component::kR9, 1.1},
                                          {Component::kR9, 0.9},
                                          {Component::kR12, 0.9},
                                          {Component::kR12, 1.2},
                                          {Component::kRa, 1.2},
                                          {Component::kRa, 0.8},
                                          {Component::kJ, 1.3},
                                          {Component::kJ, 0.7},
                                          {Component::kB, 1.3},
                                          {Component::kB, 0.7}};
    PrintFaultTable(out, settings, small, true);
  }
  if (settings.robust_trials > 0) {
    PrintRobustness(out, settings);
  }
  if (out != stdout) {
    std::fclose(out);
  }
  return 0;
}

}  // namespace
}  // namespace faultlab::study

int main(int argc, char** argv) {
  faultlab::study::Settings settings;
  for (int i = 1; i < argc; ++i) {
    const bool has_value = i + 1 < argc;
    if (std::strcmp(argv[i], "--verbose") == 0) {
      settings.verbose = true;
    } else if (std::strcmp(argv[i], "--hours") == 0 && has_value) {
      settings.hours = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--rig-minutes") == 0 && has_value) {
      settings.rig_minutes = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--trials") == 0 && has_value) {
      settings.trials = std::atoi(argv[++i]);
    } else if (std::strcmp(argv[i], "--robust-trials") == 0 && has_value) {
      settings.robust_trials = std::atoi(argv[++i]);
    } else if (std::strcmp(argv[i], "--seed") == 0 && has_value) {
      settings.seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (std::strcmp(argv[i], "-o") == 0 && has_value) {
      settings.output = argv[++i];
    } else {
      std::fprintf(stderr,
                   "usage: diagnosis_study [--hours H] [--rig-minutes M] [--trials N] [--robust-trials N] [--seed S]"
                   " [--verbose] [-o FILE]\n");
      return 2;
    }
  }
  return faultlab::study::Run(settings);
}
