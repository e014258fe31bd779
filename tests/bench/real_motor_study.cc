// A program, not a benchmark: motors with physics that the model lacks. Prints for each kind how
// often a healthy motor raises an alarm after its calibration, which faults are seen and named, and
// how far stated values are from the truth, in stated standard errors.
#include <algorithm>
#include <cmath>
#include <cstdio>
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
  double Rig::*value;
};
constexpr FaultKind kFaults[] = {
    {"Ra+20", "Ra", [](Rig& r) { r.ra *= 1.2; }, &Rig::ra},
    {"Ra+50", "Ra", [](Rig& r) { r.ra *= 1.5; }, &Rig::ra},
    {"Ke-10", "Ke", [](Rig& r) { r.ke *= 0.9, r.kt *= 0.9; }, &Rig::ke},
    {"J+30", "J", [](Rig& r) { r.j *= 1.3; }, &Rig::j},
    {"k-10", "k", [](Rig& r) { r.k *= 0.9; }, &Rig::k},
};

struct Totals {
  int motors = 0, refused = 0, own = 0, later = 0, faults = 0, named = 0, wrong = 0;
  std::vector<double> delays_s;
  std::vector<double> calibrated, values;  ///< off the truth, in stated errors
};

void PrintCoverage(const char* what, const std::vector<double>& off) {
  const auto within =
      std::count_if(off.begin(), off.end(), [](double z) { return std::abs(z) <= 1.96; });
  std::printf("%s: %zd of %zu within the stated 95 %%\n", what, within, off.size());
}

void Calibrated(const Calibration& calibration, const Rig& rig, Totals& totals) {
  const std::pair<const char*, double> truths[] = {{"Ra", rig.ra}, {"Ke", rig.ke}, {"J", rig.j}};
  for (const auto& [name, truth] : truths) {
    for (const CalibratedQuantity& q : calibration.quantities) {
      if (q.name != name) continue;
      totals.calibrated.push_back((q.value - truth) / q.sigma);
      std::printf(" %s %.3g+-%.1f%%(%.1f)",
                  name,
                  q.value,
                  100.0 * q.sigma / q.value,
                  totals.calibrated.back());
    }
  }
}

void Faulty(const Setting& setting,
            const Rig& rig,
            const DiagnosisOptions& options,
            int levels,
            unsigned seed,
            Totals& totals) {
  for (const FaultKind& fault : kFaults) {
    const auto component = setting.bench->Find(fault.symbol);
    if (!component) continue;
    Rig faulty = rig;
    fault.apply(faulty);
    std::vector<Sample> record = RecordFor(rig, faulty, kLearnS, kLearnS + 12.0, seed, levels);
    record.erase(record.begin(), record.begin() + static_cast<int>((kLearnS - 3.0) / rig.period_s));
    const Verdict v = DiagnoseRecord(record, options).verdict;
    const bool named =
        v.kind == VerdictKind::kFault && v.group.size() == 1 && v.group[0] == component;
    ++totals.faults;
    totals.named += named;
    totals.wrong += v.kind == VerdictKind::kFault && !named;
    std::printf(" %s %s", fault.name, named ? "" : Name(v.kind).data());
    if (!named) continue;
    const Candidate& c = v.candidates.front();
    totals.delays_s.push_back(*v.detected_at_s - kLearnS);
    totals.values.push_back((c.value - faulty.*fault.value) / c.sigma);
    std::printf("%.3g+-%.1f%%(%.1f)", c.value, 100.0 * c.sigma / c.value, totals.values.back());
  }
}

void Run(
    const Setting& setting, const PhysicsKind& kind, int levels, unsigned seed, Totals& totals) {
  Rig rig = setting.rig;
  rig.physics = kind.physics;
  const std::vector<Sample> record = RecordFor(rig, rig, 1e9, kLearnS + kWatchS, seed, levels);
  const auto cut = record.begin() + static_cast<int>(kLearnS / rig.period_s);
  const std::vector<Sample> learn(record.begin() + 50, cut);
  const std::vector<Sample> watch(cut, record.end());
  CalibrationOptions options;
  options.bench = setting.bench;
  options.data_sheet = setting.bench->nominal;
  options.period_s = rig.period_s;
  options.um_rail_v = setting.bench->um.exists ? setting.bench->um.max : 10.0;
  const Result<Calibration> calibration = Calibrate(learn, options);
  ++totals.motors;
  std::printf("%-8s %-9s %d  ", setting.name, kind.name, levels);
  if (!calibration.ok()) {
    ++totals.refused;
    std::printf("%.90s\n", calibration.error().message.c_str());
    return;
  }
  DiagnosisOptions diagnosis = OptionsOf(*setting.bench);
  diagnosis.calibration = calibration.value();
  const int own = AlarmsRaised(learn, diagnosis);
  const int later = AlarmsRaised(watch, diagnosis);
  totals.own += own;
  totals.later += later;
  std::printf("alarms %d, %d  level %.0f |",
              own,
              later,
              calibration.value().thresholds.glr_long *
                  std::ranges::max(calibration.value().model_error.raised[1]));
  Calibrated(calibration.value(), rig, totals);
  std::printf(" |");
  Faulty(setting, rig, diagnosis, levels, seed, totals);
  std::printf("\n");
}

}  // namespace
}  // namespace faultlab::core

int main() {
  using namespace faultlab::core;
  Totals totals;
  unsigned seed = 0;
  for (const Setting& setting : Settings()) {
    for (const PhysicsKind& kind : KindsFor(setting.rig)) {
      for (const int levels : {2, 5}) Run(setting, kind, levels, ++seed, totals);
    }
  }
  std::sort(totals.delays_s.begin(), totals.delays_s.end());
  const auto delay_s = [&](double share) {
    return totals.delays_s[static_cast<std::size_t>(
        share * static_cast<double>(totals.delays_s.size() - 1))];
  };
  std::printf(
      "\n%d motors, %d refused; alarms: %d in the %.0f s learnt from, %d in the %.0f s after\n",
      totals.motors,
      totals.refused,
      totals.own,
      kLearnS,
      totals.later,
      kWatchS);
  std::printf("faults: %d of %d named, %d wrong; delay %.2f s in the median, %.2f s in 95 %%\n",
              totals.named,
              totals.faults,
              totals.wrong,
              delay_s(0.5),
              delay_s(0.95));
  PrintCoverage("calibrated Ra, Ke, J", totals.calibrated);
  PrintCoverage("values of faults", totals.values);
}
