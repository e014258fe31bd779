// A program, not a benchmark: motors with physics that the model lacks. Prints for each kind how
// often a healthy motor raises an alarm after its calibration, and which faults are seen and named.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnose_record.h"
#include "tests/core/diagnosis/real_motors.h"

namespace faultlab::core {
namespace {

constexpr double kLearnS = 40.0;
constexpr double kWatchS = 60.0;

struct FaultKind {
  const char* name;
  const char* symbol;
  void (*apply)(Rig&);
};
constexpr FaultKind kFaults[] = {
    {"Ra+20", "Ra", [](Rig& r) { r.ra *= 1.2; }},
    {"Ra+50", "Ra", [](Rig& r) { r.ra *= 1.5; }},
    {"Ke-10",
     "Ke",
     [](Rig& r) {
       r.ke *= 0.9;
       r.kt *= 0.9;
     }},
    {"J+30", "J", [](Rig& r) { r.j *= 1.3; }},
    {"k-10", "k", [](Rig& r) { r.k *= 0.9; }},
};

int Alarms(const Diagnosis& d) {
  int alarms = 0;
  for (const FaultEpisode& e : d.episodes) alarms += static_cast<int>(1 + e.verdict.further.size());
  return alarms;
}

void Run(const Setting& setting, const PhysicsKind& kind, int levels, unsigned seed, bool faults) {
  Rig rig = setting.rig;
  rig.physics = kind.physics;
  const auto record = RecordFor(rig, rig, 1e9, kLearnS + kWatchS, seed, levels);
  const auto cut = static_cast<std::ptrdiff_t>(kLearnS / rig.period_s);
  const std::vector<Sample> learn(record.begin() + 50, record.begin() + cut);
  const std::vector<Sample> watch(record.begin() + cut, record.end());
  CalibrationOptions options;
  options.bench = setting.bench;
  options.data_sheet = setting.bench->nominal;
  options.period_s = rig.period_s;
  options.um_rail_v = setting.bench->um.exists ? setting.bench->um.max : 10.0;
  const Result<Calibration> calibration = Calibrate(learn, options);
  std::printf("%-8s %-9s %d  ", setting.name, kind.name, levels);
  if (!calibration.ok()) {
    std::printf("refused: %.90s\n", calibration.error().message.c_str());
    return;
  }
  DiagnosisOptions d = OptionsOf(*setting.bench);
  d.calibration = calibration.value();
  const DetectionThresholds& t = calibration.value().thresholds;
  std::printf("own %2d  later %2d  levels %.1f %.0f %.0f %.0f %.0f |",
              AlarmsRaised(learn, d),
              AlarmsRaised(watch, d),
              t.residual,
              t.cusum,
              t.glr_short,
              t.glr_long,
              t.glr_slow);
  for (const FaultKind& fault : kFaults) {
    if (!faults || !setting.bench->Find(fault.symbol)) continue;
    Rig faulty = rig;
    fault.apply(faulty);
    const auto later = RecordFor(rig, faulty, kLearnS, kLearnS + 12.0, seed, levels);
    const Diagnosis diagnosis =
        DiagnoseRecord(std::vector<Sample>(later.begin() + cut - 300, later.end()), d);
    const Verdict& v = diagnosis.verdict;
    const bool seen = v.detected_at_s && *v.detected_at_s >= kLearnS;
    const bool early = Alarms(diagnosis) > 0 && !diagnosis.episodes.empty() &&
                       diagnosis.episodes.front().verdict.detected_at_s.value_or(1e9) < kLearnS;
    const bool named = v.kind == VerdictKind::kFault && v.group.size() == 1 &&
                       v.group[0] == *setting.bench->Find(fault.symbol);
    std::string group;
    for (const Component c : v.group) group += std::string(Name(c)) + ' ';
    std::printf(" %s %s%s",
                fault.name,
                early ? "!" : "",
                !seen                           ? "-"
                : named                         ? "named"
                : v.kind == VerdictKind::kFault ? group.c_str()
                                                : "unknown");
    if (seen) std::printf(" %.2f", *v.detected_at_s - kLearnS);
    if (std::getenv("WHY") && !named) std::printf(" %s", v.reason.c_str());
    if (named) {
      const Candidate& c = v.candidates.front();
      const ComponentInfo& info = v.group[0].info();
      double truth = 0.0;
      if (!std::strcmp(fault.symbol, "Ra")) truth = faulty.ra;
      if (!std::strcmp(fault.symbol, "Ke")) truth = faulty.ke;
      if (!std::strcmp(fault.symbol, "J")) truth = faulty.j;
      if (!std::strcmp(fault.symbol, "k")) truth = faulty.k;
      (void)info;
      std::printf("(%.1f)", (c.value - truth) / c.sigma);
    }
  }
  std::printf("\n");
}

}  // namespace
}  // namespace faultlab::core

int main(int argc, char** argv) {
  using namespace faultlab::core;
  const bool faults = argc > 1 && !std::strcmp(argv[1], "--faults");
  unsigned seed = 0;
  for (const Setting& setting : Settings()) {
    for (const PhysicsKind& kind : KindsFor(setting.rig)) {
      for (const int levels : {2, 5}) Run(setting, kind, levels, ++seed, faults);
    }
  }
}
