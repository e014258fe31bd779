#include "tests/bench/study_trial.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <vector>

#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "tests/bench/study_bound.h"
#include "tests/paper_rig.h"

namespace faultlab::study {

using namespace core;

namespace {

/// The components that cannot be distinguished from a fault with these channels within one second,
/// the faulty one first: computed by the isolability analysis from the model of a healthy rig.
std::vector<Component> Indistinguishable(const FaultSize& fault, bool um_only) {
  IsolabilityOptions options;
  const BenchProfile& profile = paper::Hardware();
  options.bench = &paper::Bench();
  options.rig = {paper::Plant(), 1.0, profile.delta_s, profile.friction.mc_nm};
  options.noise = NoiseOf(profile, paper::Plant().gear_ratio);
  options.channels = um_only ? Channels::kUmOnly : Channels::kAll;
  options.uc_v = MakePrbs(PrbsSpec{}, 300, paper::kPeriodS);
  options.faults = {fault};
  return AnalyseIsolability(options).value().faults.front().group;
}

/// The verdict names the fault: its component, alone or with some that cannot be separated from it.
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

}  // namespace

void SolveTasks(Pipeline& pipeline) {
  while (std::optional<DiagnosisTask> task = pipeline.TakeTask()) {
    pipeline.Accept(RunTask(*task));
  }
}

PlantParameters DrawRig(double tolerance, Random& random) {
  PlantParameters rig = paper::Plant();
  for (Component component : paper::Parts()) {
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
  BenchProfile profile = paper::Hardware();
  profile.noise.um_v = setting.um_noise_v;
  Fault fault;
  fault.component = size.component;
  fault.value = relative_value ? size.value * rig.Get(size.component) : size.value;
  fault.at_s = random.Uniform(setting.at_from_s, setting.at_to_s);
  PrbsSpec prbs;
  prbs.clock_s = setting.clock_s;
  prbs.seed = 1 + random.Below(1000);
  constexpr int kSamples = 2000;
  const std::vector<double> uc_v = MakePrbs(prbs, kSamples, paper::kPeriodS);
  const std::vector<Sample> samples =
      SimulateRecord(profile, rig, uc_v, std::span<const Fault>(&fault, 1), seed, paper::kPeriodS);

  const std::vector<Component> allowed =
      Indistinguishable({fault.component, fault.value}, setting.um_only);
  DiagnosisOptions config = paper::Options();
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
          1.0 + std::floor((*verdict.detected_at_s - fault.at_s) / paper::kPeriodS + 1e-6);
    }
    if (sample.t_s < fault.at_s + 1.0) {
      outcome.isolated_1s = NamesIt(verdict, allowed);
      at_1s = verbose ? Describe(verdict) : "";
    }
  }
  const Diagnosis diagnosis = pipeline.Finish();
  outcome.calibrated = diagnosis.calibration.has_value();
  RigParameters truth{rig, 1.0, profile.delta_s, profile.friction.mc_nm};
  const NoiseLevel noise{profile.noise.um_v,
                         profile.noise.ia_a,
                         profile.noise.n_rpm * paper::kRadPerSecondOfRpm,
                         profile.friction.noise_rms_nm,
                         profile.friction.noise_tau_s};
  outcome.cramer_rao_sd = CramerRaoSd(truth, noise, fault, samples, config.channels);
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
      constexpr double kTwoSided95 = 1.959964;
      outcome.covered = std::abs(candidate.value - fault.value) <= kTwoSided95 * candidate.sigma;
    }
  }
  constexpr double kLargeError = 0.03;
  if (verbose && (!outcome.isolated || !outcome.isolated_1s || outcome.false_alarm ||
                  outcome.error > kLargeError)) {
    std::fprintf(stderr,
                 "%s%s %s=%.4g@%.2f seed %llu: delay %.0f false_alarm %d bound %.3g %%\n   1 s: "
                 "%s\n   end: %s\n",
                 setting.name,
                 setting.um_only ? " (um)" : "",
                 std::string(Name(fault.component)).c_str(),
                 fault.value,
                 fault.at_s,
                 static_cast<unsigned long long>(seed),
                 outcome.delay_samples,
                 outcome.false_alarm ? 1 : 0,
                 100.0 * outcome.cramer_rao_sd,
                 at_1s.c_str(),
                 Describe(diagnosis.verdict).c_str());
  }
  return outcome;
}

}  // namespace faultlab::study
