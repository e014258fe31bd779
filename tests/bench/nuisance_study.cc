// A program, not a benchmark: what a laboratory adds to a record, two kinds at a time and at two
// strengths, on the published bench or on one with a gear motor. Prints how often a healthy rig
// raises an alarm, and how many faults are seen, named and how exactly sized.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "tests/core/diagnosis/real_motors.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

constexpr double kFaultS = 10.0;
constexpr double kDurationS = 20.0;
constexpr double kSpeedSpikeRpm = 30.0;  // an impulse where nothing else is read
constexpr double kTau = 2.0 * std::numbers::pi;

struct Nuisances {
  double tolerance = 0.0;     // of every part, uniformly
  double warming = 0.0;       // of Ra, a second
  double cogging_nm = 0.0;    // twelve times a revolution
  double jitter_s = 0.0;      // of the output's edge, standard deviation
  double hum_um_v = 0.0;      // amplitude
  double hum_ia_a = 0.0;      // amplitude
  double impulse_rate = 0.0;  // of the samples of um
  double impulse_v = 0.0;
  double count_rpm = 0.0;  // one step of the encoder's count
  double um_zero_v = 0.0, ia_zero_a = 0.0;
  double n_gain = 0.0;
};

struct Kind {
  const char* name;
  void (*add)(Nuisances&, const Rig&, double strength);
};
constexpr Kind kKinds[] = {
    {"tolerance", [](Nuisances& n, const Rig&, double s) { n.tolerance = 0.03 * s; }},
    {"warming", [](Nuisances& n, const Rig&, double s) { n.warming = 0.001 * s; }},
    {"cogging", [](Nuisances& n, const Rig&, double s) { n.cogging_nm = 0.05e-3 * s; }},
    {"jitter", [](Nuisances& n, const Rig&, double s) { n.jitter_s = 30e-6 * s; }},
    {"hum",
     [](Nuisances& n, const Rig& r, double s) {
       n.hum_um_v = 0.045 * s, n.hum_ia_a = 5.0 * std::min(r.ia_noise, 0.005) * s;
     }},
    {"impulses",
     [](Nuisances& n, const Rig&, double s) { n.impulse_rate = 0.003 * s, n.impulse_v = 2.0; }},
    {"encoder", [](Nuisances& n, const Rig& r, double s) { n.count_rpm = 6.0 / r.gear * s; }},
    {"offset",
     [](Nuisances& n, const Rig& r, double s) {
       n.um_zero_v = 0.03 * s, n.ia_zero_a = 4.0 * std::min(r.ia_noise, 0.005) * s;
       n.n_gain = 0.005 * s;
     }},
};

struct FaultKind {
  const char* name;
  const char* symbols;  // any of them is right
  void (*apply)(Rig&);
  double (*value)(const Rig&);  // 0: not compared
};
const std::vector<FaultKind> kPaperFaults = {
    {"R1=10", "R1", [](Rig& r) { r.rs += 9.0; }, [](const Rig& r) { return r.rs; }},
    {"k x0.7", "R12 R9", [](Rig& r) { r.k *= 0.7; }, [](const Rig&) { return 0.0; }},
};
const std::vector<FaultKind> kGearFaults = {
    {"k x0.7", "k", [](Rig& r) { r.k *= 0.7; }, [](const Rig& r) { return r.k; }},
    {"Ke x0.7", "Ke", [](Rig& r) { r.ke *= 0.7, r.kt *= 0.7; }, [](const Rig& r) { return r.ke; }},
};
const std::vector<FaultKind> kMotorFaults = {
    {"healthy", "", [](Rig&) {}, [](const Rig&) { return 0.0; }},
    {"Ra x2", "Ra", [](Rig& r) { r.ra *= 2.0; }, [](const Rig& r) { return r.ra; }},
    {"Ra x1.3", "Ra", [](Rig& r) { r.ra *= 1.3; }, [](const Rig& r) { return r.ra; }},
    {"J x2", "J", [](Rig& r) { r.j *= 2.0; }, [](const Rig& r) { return r.j; }},
    {"J x0.6", "J", [](Rig& r) { r.j *= 0.6; }, [](const Rig& r) { return r.j; }},
    {"B x10", "B", [](Rig& r) { r.b *= 10.0; }, [](const Rig& r) { return r.b; }},
};

struct Studied {
  const char* name;
  const Bench* bench;
  Rig rig;
  std::vector<FaultKind> faults;
  std::vector<Channels> channels;
};

std::vector<FaultKind> WithMotorFaults(std::vector<FaultKind> faults) {
  faults.insert(faults.begin(), kMotorFaults.begin(), kMotorFaults.end());
  return faults;
}

std::vector<Studied> AllStudied() {
  const std::vector<Setting> settings = Settings();
  Rig paper = settings.back().rig;
  paper.ra = 7.41;
  paper.ke = paper.kt = 0.0255;
  paper.j = 1.43e-6;
  paper.b = 1.8e-6;
  paper.mc = 0.4e-3;
  paper.low_v = 2.0;
  paper.high_v = 3.0;
  paper.clock = 1;
  Rig gear = settings.front().rig;
  gear.clock = 5;
  Rig gear_um = gear;
  gear_um.has_um = true;
  static const Bench speed_motor = *hardware::LoadBench("speed-motor").value();
  const std::vector<FaultKind> by_gear = WithMotorFaults(kGearFaults);
  return {{"paper",
           &paper::Bench(),
           paper,
           WithMotorFaults(kPaperFaults),
           {Channels::kUmOnly, Channels::kAll}},
          {"gear", &GearMotor(false), gear, by_gear, {Channels::kAll}},
          {"gear+um", &GearMotor(true), gear_um, by_gear, {Channels::kAll}},
          {"speed", &speed_motor, gear, by_gear, {Channels::kAll}}};
}

Rig RigOf(const Studied& studied, const Nuisances& nuisances, std::mt19937& random) {
  Rig rig = studied.rig;
  std::uniform_real_distribution<double> off(1.0 - nuisances.tolerance, 1.0 + nuisances.tolerance);
  for (double Rig::*part : {&Rig::k, &Rig::rs, &Rig::ra, &Rig::ke, &Rig::j, &Rig::b, &Rig::mc}) {
    rig.*part *= off(random);
  }
  rig.kt = rig.ke;
  rig.physics.warming_per_s = nuisances.warming;
  rig.physics.magnet = 0.1;  // it is heavier than the winding
  rig.physics.cogging_nm = nuisances.cogging_nm;
  return rig;
}

std::vector<Sample> RecordOf(const Studied& studied,
                             const FaultKind& fault,
                             const Nuisances& nuisances,
                             unsigned seed,
                             double* value) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::bernoulli_distribution coin;
  std::bernoulli_distribution impulse(nuisances.impulse_rate);
  const Rig rig = RigOf(studied, nuisances, random);
  Rig faulty = rig;
  fault.apply(faulty);
  *value = fault.value(faulty);
  Motor motor(rig);
  const double hum_hz = 50.0 + 0.05 * normal(random);
  const double hum_phase = kTau * normal(random);
  std::vector<Sample> record;
  double before = rig.low_v, uc = rig.low_v;
  for (int k = 0; k * rig.period_s < kDurationS; ++k) {
    const double t_s = k * rig.period_s;
    if (t_s >= kFaultS - 1e-9) motor.rig = faulty;
    if (k % rig.clock == 0) uc = coin(random) ? rig.high_v : rig.low_v;
    const double kept = std::exp(-rig.period_s / kFrictionTauS);
    motor.drag_nm = kept * motor.drag_nm +
                    std::sqrt(1.0 - kept * kept) * rig.friction_noise_nm * normal(random);
    const double late_s = std::clamp(nuisances.jitter_s * normal(random), -0.4e-3, 0.4e-3);
    motor.Run(before, 0.4e-3 + late_s);  // the edge lies about 0.4 ms behind the clock
    motor.Run(uc, rig.delta_s - late_s);
    Sample sample;
    sample.index = k;
    sample.t_s = t_s;
    sample.uc_v = uc;
    const double hum = hum_phase + kTau * hum_hz * t_s;
    sample.um_v = motor.output_v(uc) - motor.rig.rs * motor.i + 0.015 * normal(random) +
                  nuisances.um_zero_v + nuisances.hum_um_v * std::sin(hum);
    const bool spiked = impulse(random);
    const double spike = spiked ? (coin(random) ? 1.0 : -1.0) : 0.0;
    sample.um_v += spike * nuisances.impulse_v;
    sample.ia_a = motor.i + rig.ia_noise * normal(random) + nuisances.ia_zero_a +
                  nuisances.hum_ia_a * std::sin(hum + 0.7);
    if (!rig.has_um) sample.um_v = 0.0, sample.ia_a += spike;
    const bool speed_alone = !studied.bench->um.exists && !studied.bench->ia.exists;
    double n = motor.w * 30.0 / std::numbers::pi / rig.gear * (1.0 + nuisances.n_gain) +
               rig.n_noise * normal(random);
    if (speed_alone) n += spike * kSpeedSpikeRpm;
    sample.n_rpm =
        nuisances.count_rpm > 0.0 ? nuisances.count_rpm * std::round(n / nuisances.count_rpm) : n;
    record.push_back(sample);
    before = uc;
    motor.Run(uc, rig.period_s - rig.delta_s - 0.4e-3);
  }
  return record;
}

struct Totals {
  int healthy = 0, alarms = 0, faults = 0, seen = 0, named = 0, wrong = 0, early = 0, covered = 0,
      valued = 0;
  std::vector<double> errors;
};

std::string Described(const Verdict& verdict) {
  std::string text(Name(verdict.kind));
  for (const Component member : verdict.group) text += " " + std::string(Name(member));
  if (verdict.detected_at_s) text += " at " + std::to_string(*verdict.detected_at_s) + " s";
  return text + ": " + verdict.reason.substr(0, 150);
}

void Diagnose(const Studied& studied,
              const FaultKind& fault,
              const std::vector<Sample>& record,
              double value,
              Channels channels,
              const std::string& what,
              Totals& totals) {
  DiagnosisOptions options = OptionsOf(*studied.bench);
  options.channels = channels;
  options.model = ModelScope::kBuiltRig;  // as the server takes every rig with relays
  const Diagnosis diagnosis = DiagnoseRecord(record, options);
  const Verdict& verdict = diagnosis.verdict;
  const bool refused = diagnosis.calibration_refusal.has_value();
  const bool healthy = fault.symbols[0] == '\0';
  const bool early = verdict.detected_at_s && *verdict.detected_at_s < kFaultS - 1e-9;
  bool named = verdict.kind == VerdictKind::kFault && !early;
  for (const Component member : verdict.group) {
    named &= std::strstr(fault.symbols, Name(member).data()) != nullptr;
  }
  std::string missed;
  if (healthy) {
    ++totals.healthy;
    const bool alarm = verdict.kind != VerdictKind::kNominal || !diagnosis.episodes.empty();
    totals.alarms += alarm;
    if (alarm || refused) missed = "ALARM";
  } else {
    ++totals.faults;
    totals.seen += verdict.detected_at_s.has_value() && !early;
    totals.early += early;
    totals.named += named;
    totals.wrong += verdict.kind == VerdictKind::kFault && !named;
    if (!named) missed = "MISSED";
    if (named && value > 0.0) {
      const Candidate& c = verdict.candidates.front();
      totals.errors.push_back(std::abs(c.value / value - 1.0));
      ++totals.valued;
      const double off = (c.value - value) / c.sigma;
      totals.covered += std::abs(off) <= 1.96;
      if (std::abs(off) > 1.96) {
        std::printf("OUTSIDE %s %s: %.4g +- %.2g, is %.4g: %.1f sigma\n",
                    what.c_str(),
                    channels == Channels::kAll ? "all" : "um",
                    c.value,
                    c.sigma,
                    value,
                    off);
      }
    }
  }
  if (missed.empty()) return;
  std::printf("%s %s %s: %s\n",
              missed.c_str(),
              what.c_str(),
              channels == Channels::kAll ? "all" : "um",
              Described(verdict).c_str());
  if (refused) std::printf("   refused: %s\n", diagnosis.calibration_refusal->message.c_str());
}

void Print(const char* channels, double strength, Totals& totals) {
  std::sort(totals.errors.begin(), totals.errors.end());
  const auto share = [&](double p) {
    return totals.errors.empty() ? 0.0
                                 : 100.0 * totals.errors[static_cast<std::size_t>(
                                               p * static_cast<double>(totals.errors.size() - 1))];
  };
  std::printf(
      "%s x%.1f: alarms %d of %d; faults %d: seen %d, named %d, wrong %d, alarms before %d; error "
      "%.2f %% median, %.2f %% in 95 %%; %d of %d within the stated 95 %%\n",
      channels,
      strength,
      totals.alarms,
      totals.healthy,
      totals.faults,
      totals.seen,
      totals.named,
      totals.wrong,
      totals.early,
      share(0.5),
      share(0.95),
      totals.covered,
      totals.valued);
}

void Study(const Studied& studied, double strength, unsigned& seed) {
  std::vector<Totals> totals(studied.channels.size());
  for (const Kind& one : kKinds) {
    for (const Kind& other : kKinds) {
      if (&other < &one) continue;  // with itself: that kind alone
      Nuisances nuisances;
      one.add(nuisances, studied.rig, strength);
      other.add(nuisances, studied.rig, strength);
      for (const FaultKind& fault : studied.faults) {
        double value = 0.0;
        const std::vector<Sample> record = RecordOf(studied, fault, nuisances, ++seed, &value);
        const std::string what = std::string(one.name) + "+" + other.name + " " + fault.name + " " +
                                 std::to_string(seed);
        for (std::size_t k = 0; k < totals.size(); ++k) {
          Diagnose(studied, fault, record, value, studied.channels[k], what, totals[k]);
        }
      }
    }
  }
  for (std::size_t k = 0; k < totals.size(); ++k) {
    Print(studied.channels[k] == Channels::kAll ? "all" : "um", strength, totals[k]);
  }
}

}  // namespace
}  // namespace faultlab::core

// nuisance_study [BENCH [SEED [STRENGTH..]]]
int main(int argc, char** argv) {
  using namespace faultlab::core;
  const std::string bench = argc > 1 ? argv[1] : "paper";
  unsigned seed = argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1;
  std::vector<double> strengths;
  for (int k = 3; k < argc; ++k) strengths.push_back(std::atof(argv[k]));
  if (strengths.empty()) strengths = {1.0, 2.0};
  for (const Studied& studied : AllStudied()) {
    if (studied.name != bench) continue;
    for (const double strength : strengths) Study(studied, strength, seed);
    return 0;
  }
  std::fprintf(stderr, "nuisance_study: no bench %s: paper, gear, gear+um, speed\n", bench.c_str());
  return 2;
}
