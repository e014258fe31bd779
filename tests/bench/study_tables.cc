#include "tests/bench/study_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/numerics/statistics.h"
#include "tests/bench/study_trial.h"
#include "tests/paper_bench.h"

namespace faultlab::study {

using namespace core;

namespace {

struct Tally {
  int trials = 0;
  int detected = 0;
  int early = 0;  ///< false alarms before the fault
  int isolated_1s = 0;
  int isolated = 0;
  int bounds = 0;
  int covered = 0;  ///< of `errors`
  std::vector<double> delays;
  std::vector<double> errors;
  std::vector<double> best_sds;  ///< Cramer-Rao, of the same records as `errors`

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
      best_sds.push_back(outcome.cramer_rao_sd);
      covered += outcome.covered;
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

std::string BestSd(const Tally& tally) {
  return tally.errors.empty() ? std::string("-") : Percent(Quantile(tally.best_sds, 0.5));
}

std::string Count(int hits, int trials) {
  return std::to_string(hits) + "/" + std::to_string(trials);
}

std::string Coverage(const Tally& tally) {
  return tally.errors.empty() ? std::string("-")
                              : Count(tally.covered, static_cast<int>(tally.errors.size()));
}

std::string Delays(const Tally& tally) {
  return Samples(Quantile(tally.delays, 0.5)) + " / " + Samples(Quantile(tally.delays, 0.95));
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

}  // namespace

void PrintFaultTable(std::FILE* out,
                     const Settings& settings,
                     std::span<const FaultSize> faults,
                     bool relative_value) {
  std::fprintf(out,
               "| fault | channels | delay, median / 95 %% | isolated after 1 s | at the end | "
               "error, median / worst | best possible (1 sd) | truth in stated 95 %% |\n"
               "|---|---|---|---|---|---|---|---|\n");
  const auto row = [&](const std::string& name, bool um_only, const Tally& tally, bool interval) {
    const auto rate = [&](int hits) {
      return interval ? Rate(hits, tally.trials) : Count(hits, tally.trials);
    };
    std::fprintf(out,
                 "| %s | %s | %s | %s | %s | %s | %s | %s |\n",
                 name.c_str(),
                 um_only ? "um" : "um+ia+n",
                 Delays(tally).c_str(),
                 rate(tally.isolated_1s).c_str(),
                 rate(tally.isolated).c_str(),
                 Errors(tally).c_str(),
                 BestSd(tally).c_str(),
                 Coverage(tally).c_str());
    std::fflush(out);
  };
  for (const bool um_only : {true, false}) {
    Tally total;
    for (const FaultSize& fault : faults) {
      Tally tally;
      Case setting{"nominal"};
      setting.um_only = um_only;
      for (int trial = 0; trial < settings.trials; ++trial) {
        const std::uint64_t seed = StreamSeed(settings.seed, static_cast<std::uint64_t>(trial));
        const Outcome outcome = RunTrial(setting, fault, seed, relative_value, settings.verbose);
        tally.Add(outcome);
        total.Add(outcome);
      }
      row(FaultName(fault, relative_value), um_only, tally, false);
    }
    row("**all**", um_only, total, true);
  }
  std::fprintf(out, "\n");
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
               "isolated after 1 s | at the end | error, median / worst | truth in stated 95 %% |\n"
               "|---|---|---|---|---|---|---|---|\n");
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
                 "| %s | %s | %s | %s | %s | %s | %s | %s |\n",
                 setting.name,
                 setting.um_only ? "um" : "um+ia+n",
                 Rate(tally.early, tally.trials).c_str(),
                 Rate(tally.detected, tally.trials).c_str(),
                 Rate(tally.isolated_1s, tally.trials).c_str(),
                 Rate(tally.isolated, tally.trials).c_str(),
                 Errors(tally).c_str(),
                 Coverage(tally).c_str());
    std::fflush(out);
  };
  for (const Case& setting : cases) {
    row(setting, FaultsOf(paper::Bench()));
  }
  // Gains that drive um beyond the converter's +-10 V at the upper level of the input.
  const std::vector<FaultSize> clipping = {{paper::kR12, 18e3}, {paper::kR9, 5e3}};
  for (const bool um_only : {true, false}) {
    row({.name = "um clipped at the rail (R12 18 k, R9 5 k)", .um_only = um_only}, clipping);
  }
}

}  // namespace faultlab::study
