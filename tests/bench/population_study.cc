// A program, not a benchmark: the simulator's rigs of all benches, every part off its data sheet,
// under inputs that switch, sum or sweep, with a fault of the bench's list that comes at once or
// creeps, and two of a laboratory's nuisances. Each seed is one record. Prints every one that is
// not diagnosed as it should be; last, the reliability diagram of core/study.md.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/control/closed_loop/orders.h"
#include "core/diagnosis/diagnose_record.h"
#include "core/isolability/isolability.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "hardware/bench/benches.h"

namespace faultlab::core {
namespace {

constexpr double kTolerance = 0.03;  // of every part
constexpr double kTau = 2.0 * std::numbers::pi;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double Real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int Whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  double Normal() { return std::normal_distribution<double>()(random_); }

 private:
  std::mt19937 random_;
};

struct Trial {
  const Bench* bench = nullptr;
  std::string text;  // what it is
  std::vector<Fault> faults;
  std::vector<Sample> samples;
  Channels channels = Channels::kAll;
};

ExcitationSpec InputOf(const Bench& bench, int kind, unsigned seed, Draw& draw) {
  const double low = bench.limits.uc_v_min;
  const DriveModel drive = DescribedDrive(bench, bench.period_s);
  // A current that is held drives the motor as fast as the supply lets it.
  const double high = bench.structure->drives_current()
                          ? drive.speed.InputFor(drive.reachable_rad_s(), drive.reachable_rad_s())
                          : bench.limits.uc_v_max;
  double mid = low + (high - low) * draw.Real(0.4, 0.6);
  double amplitude = (high - low) * draw.Real(0.08, 0.25);
  if (low < 0.0) mid = 0.35 * high, amplitude = high * draw.Real(0.08, 0.25);
  if (kind < 6) {
    PrbsSpec prbs;
    prbs.low_v = mid - amplitude;
    prbs.high_v = mid + amplitude;
    prbs.clock_s = bench.period_s * draw.Whole(1, 6);
    prbs.seed = seed + 1;
    return prbs;
  }
  if (kind < 9) {
    MultisineSpec multisine;
    multisine.offset_v = mid;
    multisine.amplitude_v = amplitude;
    multisine.lines = 20;
    multisine.seed = seed;
    return multisine;
  }
  ChirpSpec chirp;
  chirp.offset_v = mid;
  chirp.amplitude_v = amplitude;
  chirp.from_hz = 0.2;
  chirp.to_hz = 8.0;
  return chirp;
}

// One of seven, where the bench reads what it disturbs.
void AddNuisance(const Bench& bench, Draw& draw, Trial& trial) {
  const bool um = bench.um.exists, ia = bench.ia.exists, n = bench.n.exists;
  const double um_v = bench.um.noise > 0.0 ? bench.um.noise : 15e-3;
  const double ia_a = std::min(bench.ia.noise > 0.0 ? bench.ia.noise : 1e-3, 5e-3);
  const double n_rpm = bench.n.noise > 0.0 ? bench.n.noise : 0.5;
  const double strength = draw.Real(0.3, 2.0);
  const char* name = "";
  switch (draw.Whole(0, 6)) {
    case 0: {
      name = "hum";
      const double hz = 50.0 + 0.05 * draw.Normal(), phase = draw.Real(0.0, 6.0);
      for (Sample& s : trial.samples) {
        const double angle = phase + kTau * hz * s.t_s;
        if (um) s.um_v += 3.0 * um_v * strength * std::sin(angle);
        if (ia) s.ia_a += 3.0 * ia_a * strength * std::sin(angle + 0.7);
      }
      break;
    }
    case 1:
      name = "impulses";
      for (Sample& s : trial.samples) {
        if (draw.Real(0.0, 1.0) >= 0.003 * strength) continue;
        const double sign = draw.Real(0.0, 1.0) < 0.5 ? 1.0 : -1.0;
        if (um) {
          s.um_v += 2.0 * sign;
        } else if (ia) {
          s.ia_a += sign;
        } else {
          s.n_rpm += 60.0 * n_rpm * sign;
        }
      }
      break;
    case 2:
      if (!n) break;
      name = "counts";
      for (Sample& s : trial.samples) {
        const double count = 3.0 * n_rpm * strength;
        s.n_rpm = count * std::round(s.n_rpm / count);
      }
      break;
    case 3:
      if (!um) break;
      name = "zero of um";
      for (Sample& s : trial.samples) s.um_v += 2.0 * um_v * strength;
      break;
    case 4:
      if (!ia) break;
      name = "zero of ia";
      for (Sample& s : trial.samples) s.ia_a += 4.0 * ia_a * strength;
      break;
    case 5:
      if (!n) break;
      name = "gain of n";
      for (Sample& s : trial.samples) s.n_rpm *= 1.0 + 0.005 * strength;
      break;
    case 6:
      name = "lost samples";
      std::erase_if(trial.samples, [&](const Sample& s) {
        return s.index >= 3 && draw.Real(0.0, 1.0) <= 0.004 * strength;
      });
      break;
  }
  if (*name == '\0') return;
  char text[40];
  std::snprintf(text, sizeof text, ", %s x%.1f", name, strength);
  trial.text += text;
}

Trial TrialOf(const std::vector<const Bench*>& benches, unsigned seed) {
  Draw draw(seed);
  Trial trial;
  trial.bench =
      benches[static_cast<std::size_t>(draw.Whole(0, static_cast<int>(benches.size()) - 1))];
  const Bench& bench = *trial.bench;
  const int input = draw.Whole(0, 9);
  PlantParameters rig = bench.nominal;
  for (int k = 0; k < static_cast<int>(rig.structure->parameters.size()); ++k) {
    rig.Set(k, rig.Get(k) * draw.Real(1.0 - kTolerance, 1.0 + kTolerance));
  }
  rig.kt_nm_per_a = rig.ke_v_per_rad_s;
  const double duration_s = std::max(20.0, 2000.0 * bench.period_s);
  const ExcitationSpec spec = InputOf(bench, input, seed, draw);
  const std::vector<double> uc_v = Generate(spec, duration_s, bench.period_s).value();
  const std::vector<FaultSize> listed = FaultsOf(bench);
  const bool healthy = draw.Whole(0, 4) == 0;
  const bool creeps = draw.Whole(0, 9) >= 8;
  const FaultSize& size =
      listed[static_cast<std::size_t>(draw.Whole(0, static_cast<int>(listed.size()) - 1))];
  const double at_s = draw.Real(0.35, 0.7) * duration_s;
  trial.text = bench.name + ", " + std::string(Name(spec));
  if (!healthy) {
    Fault fault;
    fault.component = size.component;
    fault.value = size.value;
    fault.at_s = at_s;
    if (creeps) fault.kind = FaultKind::kDrift, fault.until_s = at_s + draw.Real(2.0, 6.0);
    trial.faults.push_back(fault);
    char text[80];
    std::snprintf(text,
                  sizeof text,
                  ", %s %s %.4g at %.2f s",
                  Name(fault.component).data(),
                  creeps ? "creeps to" : "=",
                  fault.value,
                  at_s);
    trial.text += text;
  }
  trial.samples =
      SimulateRecord(bench.profiles.front(), rig, uc_v, trial.faults, seed, bench.period_s);
  for (int k = 0; k < 2; ++k) AddNuisance(bench, draw, trial);
  const bool by_um = draw.Whole(0, 2) == 0;
  if (by_um && bench.um.exists && (bench.ia.exists || bench.n.exists)) {
    trial.channels = Channels::kUmOnly;
    trial.text += ", by um alone";
  }
  return trial;
}

enum class Outcome { kRight, kRefused, kAlarm, kEarly, kWrong, kUnknown, kMissed, kValue };
constexpr const char* kOutcomes[] = {
    "right", "refused", "ALARM", "EARLY", "WRONG", "UNKNOWN", "MISSED", "VALUE"};

Outcome OutcomeOf(const Trial& trial, const Diagnosis& diagnosis) {
  const Verdict& verdict = diagnosis.verdict;
  if (diagnosis.calibration_refusal) return Outcome::kRefused;
  if (trial.faults.empty()) {
    const bool alarm = verdict.kind != VerdictKind::kNominal || !diagnosis.episodes.empty();
    return alarm ? Outcome::kAlarm : Outcome::kRight;
  }
  const Fault& fault = trial.faults.front();
  if (verdict.detected_at_s && *verdict.detected_at_s < fault.at_s - 1e-9) return Outcome::kEarly;
  if (verdict.kind == VerdictKind::kUnknownFault) return Outcome::kUnknown;
  if (verdict.kind != VerdictKind::kFault) return Outcome::kMissed;
  const std::vector<Component>& group = verdict.group;
  if (std::find(group.begin(), group.end(), fault.component) == group.end()) {
    return Outcome::kWrong;
  }
  const Candidate& best = verdict.candidates.front();
  if (group.size() > 1 || fault.kind != FaultKind::kAbrupt || best.bound != 0) {
    return Outcome::kRight;
  }
  const bool far = std::abs(best.value / fault.value - 1.0) > 0.05 &&
                   std::abs(best.value - fault.value) > 4.0 * best.sigma;
  return far ? Outcome::kValue : Outcome::kRight;
}

std::string Described(const Diagnosis& diagnosis) {
  if (diagnosis.calibration_refusal) return diagnosis.calibration_refusal->message;
  const Verdict& verdict = diagnosis.verdict;
  std::string text(Name(verdict.kind));
  for (const Component member : verdict.group) text += " " + std::string(Name(member));
  if (verdict.detected_at_s) text += " at " + std::to_string(*verdict.detected_at_s) + " s";
  return text + ": " + verdict.reason;
}

/// How often a name was right, by the probability that it was told with.
class Reliability {
 public:
  explicit Reliability(const char* of) : of_(of) {}

  void Add(const Verdict& verdict, const Fault& fault) {
    const double probability = ProbabilityOf(verdict);
    std::size_t bin = 0;
    while (bin + 1 < kFrom.size() && probability >= kFrom[bin + 1]) ++bin;
    ++all_[bin];
    sum_[bin] += probability;
    right_[bin] += std::ranges::find(verdict.group, fault.component) != verdict.group.end();
  }
  /// Rows of a table: told as sure as, in the mean, how many, right of them.
  void Print() {
    for (std::size_t bin = 0; bin < kFrom.size(); ++bin) {
      if (all_[bin] == 0) continue;
      std::printf("| %s | from %.6g | %.4f | %d | %d | %.4f |\n",
                  of_,
                  kFrom[bin],
                  sum_[bin] / all_[bin],
                  all_[bin],
                  right_[bin],
                  static_cast<double>(right_[bin]) / all_[bin]);
    }
  }

 private:
  static constexpr std::array<double, 6> kFrom = {0.0, 0.5, 0.9, 0.99, 0.999, 0.9999};
  const char* of_;
  std::array<int, kFrom.size()> all_{};
  std::array<int, kFrom.size()> right_{};
  std::array<double, kFrom.size()> sum_{};
};

int Study(unsigned from, unsigned to) {
  const std::vector<const Bench*> benches = hardware::LoadShippedBenches();
  int healthy = 0, faulty = 0, named = 0, soon = 0;
  Reliability firsts("first name"), lasts("last name");
  int counts[std::size(kOutcomes)] = {};
  for (unsigned seed = from; seed < to; ++seed) {
    const Trial trial = TrialOf(benches, seed);
    DiagnosisOptions options = OptionsOf(*trial.bench, trial.bench->period_s);
    if (trial.bench->um.exists) options.um_rail_v = trial.bench->um.max;
    options.channels = trial.channels;
    std::optional<Verdict> first;
    double first_s = 0.0;
    const Diagnosis diagnosis =
        DiagnoseRecord(trial.samples, options, [&](const Verdict& verdict, std::int64_t index) {
          if (first || verdict.kind != VerdictKind::kFault || verdict.group.empty()) return;
          first = verdict;
          first_s = static_cast<double>(index) * trial.bench->period_s;
        });
    const Outcome outcome = OutcomeOf(trial, diagnosis);
    const auto index = static_cast<std::size_t>(outcome);
    ++counts[index];
    if (outcome != Outcome::kRefused) ++(trial.faults.empty() ? healthy : faulty);
    const Verdict& last = diagnosis.verdict;
    if (!trial.faults.empty() && first && last.kind == VerdictKind::kFault) {
      firsts.Add(*first, trial.faults.front());
      ++named;
      soon += first_s - first->detected_at_s.value_or(0.0) < 0.0501;
      lasts.Add(last, trial.faults.front());
    }
    if (outcome == Outcome::kRight) continue;
    std::printf("%s %u: %s: %s\n",
                kOutcomes[index],
                seed,
                trial.text.c_str(),
                Described(diagnosis).c_str());
    std::fflush(stdout);
  }
  firsts.Print();
  lasts.Print();
  std::printf("first names within 0.05 s of the alarm: %d of %d\n", soon, named);
  std::printf("%d healthy, %d with a fault", healthy, faulty);
  for (std::size_t k = 0; k < std::size(kOutcomes); ++k) {
    std::printf("; %s %d", kOutcomes[k], counts[k]);
  }
  std::printf("\n");
  return 0;
}

}  // namespace
}  // namespace faultlab::core

// population_study [FROM TO]: the seeds [FROM, TO).
int main(int argc, char** argv) {
  const int from = argc > 2 ? std::atoi(argv[1]) : 0;
  const int to = argc > 2 ? std::atoi(argv[2]) : 300;
  if (from < 0 || to <= from) {
    std::fprintf(stderr, "population_study [FROM TO]: seeds from 0 on, FROM < TO\n");
    return 2;
  }
  return faultlab::core::Study(static_cast<unsigned>(from), static_cast<unsigned>(to));
}
