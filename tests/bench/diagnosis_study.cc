// A seeded Monte Carlo study of the diagnosis: false alarms on healthy rigs, and, for each fault,
// the delay of detection, the rate of correct isolation and the error of identification.
//   diagnosis_study [--hours H] [--rig-minutes M] [--trials N] [--robust-trials N] [--seed S]
//   [--verbose] [-o FILE]
// Writes markdown. Every number comes from a simulation with core's plant, diagnosed by core's
// pipeline as in a live run, without a list of possible values; the same seed gives the same table.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "core/numerics/statistics.h"
#include "tests/bench/study_alarms.h"
#include "tests/bench/study_tables.h"
#include "tests/paper_bench.h"

namespace faultlab::study {
namespace {

using namespace core;

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
    PrintFaultTable(out, settings, FaultsOf(paper::Bench()), false);
    const std::vector<FaultSize> small = {{paper::kR1, 1.3},
                                          {paper::kR9, 1.1},
                                          {paper::kR9, 0.9},
                                          {paper::kR12, 0.9},
                                          {paper::kR12, 1.2},
                                          {paper::kRa, 1.2},
                                          {paper::kRa, 0.8},
                                          {paper::kJ, 1.3},
                                          {paper::kJ, 0.7},
                                          {paper::kB, 1.3},
                                          {paper::kB, 0.7}};
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
                   "usage: diagnosis_study [--hours H] [--rig-minutes M] [--trials N] "
                   "[--robust-trials N] [--seed S]"
                   " [--verbose] [-o FILE]\n");
      return 2;
    }
  }
  return faultlab::study::Run(settings);
}
