// CPU time of the tasks outside the sample path: calibration, and isolation at every stage of a
// fault. Goal: 20 ms each, so that a verdict is renewed while the next samples arrive.
//   isolation_bench [--each]     --each: a line for every task slower than the goal
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/diagnosis/pipeline.h"
#include "core/isolability/isolability.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

constexpr double kGoalMs = 20.0;

double CpuMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Costs {
  std::vector<double> calibrate_ms;
  std::vector<double> single_ms;
  std::vector<double> unknown_ms;
};

Fault At(Component component, double value, FaultKind kind = FaultKind::kAbrupt) {
  Fault fault;
  fault.component = component;
  fault.value = value;
  fault.at_s = 8.0;
  fault.kind = kind;
  fault.until_s = 18.0;
  return fault;
}

void Run(const std::vector<Fault>& faults, Channels channels, bool each, Costs& costs) {
  const std::vector<double> uc_v = MakePrbs(PrbsSpec{}, 2000, paper::kPeriodS);
  const std::vector<Sample> samples =
      SimulateRecord(paper::Hardware(), paper::Plant(), uc_v, faults, 3, paper::kPeriodS);
  DiagnosisOptions config = paper::Options();
  config.channels = channels;
  Pipeline pipeline(config);
  for (const Sample& sample : samples) {
    pipeline.Push(sample);
    while (std::optional<DiagnosisTask> task = pipeline.TakeTask()) {
      const double start = CpuMs();
      DiagnosisResult result = RunTask(*task);
      const double ms = CpuMs() - start;
      const auto* isolation = std::get_if<IsolationTask>(&*task);
      if (isolation == nullptr) {
        costs.calibrate_ms.push_back(ms);
      } else {
        const Verdict& verdict = std::get<IsolationResult>(result).verdict;
        const bool unknown = verdict.kind == VerdictKind::kUnknownFault;
        (unknown ? costs.unknown_ms : costs.single_ms).push_back(ms);
        if (each && ms > kGoalMs) {
          std::printf("%6.1f ms  %s, %zu samples, %s\n",
                      ms,
                      faults.empty() ? "healthy" : std::string(Name(faults[0].component)).c_str(),
                      isolation->samples.size() - isolation->fit_from,
                      verdict.reason.c_str());
        }
      }
      pipeline.Accept(std::move(result));
    }
  }
}

void Print(const char* what, std::vector<double> ms) {
  if (ms.empty()) return;
  std::sort(ms.begin(), ms.end());
  double sum = 0.0;
  for (double value : ms) sum += value;
  std::printf("  %-40s %4zu tasks  median %6.1f  95 %% %6.1f  worst %6.1f ms  goal %.0f\n",
              what,
              ms.size(),
              ms[ms.size() / 2],
              ms[ms.size() * 95 / 100],
              ms.back(),
              kGoalMs);
}

void Main(bool each) {
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    Costs costs;
    for (const FaultSize& fault : FaultsOf(paper::Bench())) {
      Run({At(fault.component, fault.value)}, channels, each, costs);
    }
    Run({At(paper::kR9, 18e3, FaultKind::kDrift)}, channels, each, costs);
    Run({At(paper::kRa, 15.0, FaultKind::kDrift)}, channels, each, costs);
    Run({At(paper::kR1, 5.0), At(paper::kJ, 4e-6)}, channels, each, costs);
    Run({At(paper::kRa, 4.0), At(paper::kB, 2e-5)}, channels, each, costs);
    std::printf("%s\n", channels == Channels::kUmOnly ? "um" : "um+ia+n");
    Print("calibration, 450 samples", costs.calibrate_ms);
    Print("isolation, a component is named", costs.single_ms);
    Print("isolation, unknown or moving", costs.unknown_ms);
  }
}

}  // namespace
}  // namespace faultlab::core

int main(int argc, char** argv) {
  faultlab::core::Main(argc > 1 && std::strcmp(argv[1], "--each") == 0);
  return 0;
}
