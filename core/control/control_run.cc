#include "core/control/control_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "core/diagnosis/diagnosis_options.h"
#include "core/diagnosis/pipeline.h"
#include "core/plant/converters.h"
#include "core/plant/fault_schedule.h"
#include "core/plant/plant.h"
#include "core/signals/excitation.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

// The control begins when the healthy stretch of the pipeline is over.
constexpr double kAfterLearningS = 0.5;
// Without a fault the quality is judged from here on.
constexpr double kRunInS = 4.5;
// A hold is judged by its last quarter.
constexpr int kHoldPeriodsMin = 8;
constexpr double kSecondsMax = 3600.0;
constexpr double kSettledShare = 0.05;
constexpr double kSteadyShare = 0.25;

Error Refuse(std::string message, std::string field) {
  return {ErrorCode::kInvalid, std::move(message), std::move(field), "internal"};
}

std::size_t TicksOf(const ControlPlan& plan, double seconds) {
  return static_cast<std::size_t>(std::lround(seconds / plan.bench->period_s));
}

/// @param tick  since the control began
double ReferenceAt(const ControlPlan& plan, std::size_t tick) {
  return tick / TicksOf(plan, plan.hold_s) % 2 == 0 ? plan.low_rad_s : plan.high_rad_s;
}

Status Check(const ControlPlan& plan) {
  const Bench& bench = *plan.bench;
  if (!bench.n.exists) return Refuse("the bench " + bench.name + " does not measure n", "bench");
  if (!(plan.low_rad_s > 0.0) || !(plan.high_rad_s > 0.0)) {
    return Refuse("a reference is two speeds above 0", "reference");
  }
  if (!(plan.hold_s >= kHoldPeriodsMin * bench.period_s && plan.hold_s <= kSecondsMax)) {
    return Refuse("a speed is held for at least " + std::to_string(kHoldPeriodsMin) +
                      " periods of the bench, and for at most an hour",
                  "hold_s");
  }
  if (!(plan.duration_s > 0.0 && plan.duration_s <= kSecondsMax)) {
    return Refuse("a run lasts an hour at most", "duration_s");
  }
  return Done{};
}

ControlQuality QualityOf(const ControlPlan& plan, const ControlRecord& record, double from_s) {
  const double period_s = plan.bench->period_s;
  const double height = std::abs(plan.high_rad_s - plan.low_rad_s);
  ControlQuality quality;
  const std::size_t begin = TicksOf(plan, from_s);
  const std::size_t hold = TicksOf(plan, plan.hold_s);
  const std::size_t control = TicksOf(plan, record.control_from_s);
  std::size_t last_out = 0;
  double steady_sum = 0.0;
  std::size_t steady = 0;
  std::size_t last_step = begin;
  for (std::size_t k = begin; k < record.speed_rad_s.size(); ++k) {
    const double reference = record.reference_rad_s[k];
    const double error = reference - record.speed_rad_s[k];
    quality.iae_rad += std::abs(error) * period_s;
    if (k >= begin + 2 * hold) quality.late_iae_rad += std::abs(error) * period_s;
    const std::size_t in_hold = (k - control) % hold;
    if (in_hold == 0) last_step = k;
    const bool up = reference == std::max(plan.low_rad_s, plan.high_rad_s);
    const double beyond = up ? -error : error;
    if (k >= begin + hold && height > 0.0) {
      quality.overshoot_percent = std::max(quality.overshoot_percent, 100.0 * beyond / height);
    }
    if (std::abs(error) > kSettledShare * std::max(height, 1.0)) last_out = k;
    if (static_cast<double>(in_hold) >= (1.0 - kSteadyShare) * static_cast<double>(hold)) {
      steady_sum += error;
      ++steady;
    }
    if (in_hold + 1 == hold && steady > 0) {
      const double mean = std::abs(steady_sum / static_cast<double>(steady));
      quality.steady_error_rad_s = std::max(quality.steady_error_rad_s, mean);
      steady_sum = 0.0;
      steady = 0;
    }
  }
  if (last_out + 1 < record.speed_rad_s.size()) {
    const std::size_t from = std::max(last_step, begin);
    quality.settling_s =
        last_out < from ? 0.0 : static_cast<double>(last_out + 1 - from) * period_s;
  }
  return quality;
}

Verdict VerdictOf(const Fault& fault) {
  Verdict verdict;
  verdict.kind = VerdictKind::kFault;
  verdict.settled = true;
  verdict.group = {fault.component};
  verdict.candidates = {{.component = fault.component, .value = fault.value}};
  return verdict;
}

/// The alarm alone.
Verdict WithoutName(Verdict verdict) {
  if (verdict.kind == VerdictKind::kFault) verdict.kind = VerdictKind::kUnknownFault;
  return verdict;
}

}  // namespace

Result<ControlRecord> RunControl(const ControlPlan& plan) {
  LAB_CHECK(plan.bench != nullptr);
  if (const Status checked = Check(plan); !checked) return checked.error();
  const Bench& bench = *plan.bench;
  const DiagnosisOptions options = OptionsOf(bench);
  const double control_from_s = options.healthy_to_s + kAfterLearningS;
  const auto learning = Generate(bench.excitation, control_from_s, bench.period_s);
  if (!learning) return learning.error();
  const std::size_t ticks = TicksOf(plan, plan.duration_s);
  if (ticks <= learning.value().size()) {
    return Refuse("the run ends before the rig is learnt", "duration_s");
  }

  const BenchProfile& profile = bench.profiles.front();
  Plant plant(bench.nominal, profile, StreamSeed(plan.seed, 0));
  MeasurementNoise noise(profile.noise, StreamSeed(plan.seed, 1));
  FaultSchedule schedule(plan.faults, bench.nominal);
  PulseCounter counter(profile.converters.pulses_per_revolution, bench.nominal.gear_ratio);
  Pipeline pipeline(options);
  std::optional<TolerantDrive> drive;
  const double rad_per_s = RadPerSecondOfRpm(bench.nominal.gear_ratio);

  ControlRecord record;
  record.control_from_s = control_from_s;
  std::uint64_t heard = 0;
  bool told = false;
  for (std::size_t k = 0; k < ticks; ++k) {
    Sample sample;
    sample.index = static_cast<std::int64_t>(k);
    sample.t_s = static_cast<double>(k) * bench.period_s;
    double reference = std::numeric_limits<double>::quiet_NaN();
    double u = 0.0;
    if (k < learning.value().size()) {
      u = learning.value()[k];
    } else {
      if (!drive) {
        const auto calibration = pipeline.calibration();
        if (!calibration) return Refuse(pipeline.verdict().reason, "bench");
        drive.emplace(
            bench, *calibration, bench.period_s, plan.options, record.samples.back().uc_v);
        const double highest = std::max(plan.low_rad_s, plan.high_rad_s);
        if (highest > drive->reachable_rad_s()) {
          return Refuse("the healthy rig reaches " + std::to_string(drive->reachable_rad_s()) +
                            " rad/s, the reference asks for " + std::to_string(highest),
                        "reference");
        }
        heard = pipeline.verdict_version();
      }
      reference = ReferenceAt(plan, k - learning.value().size());
      u = drive->Tick(reference, record.samples.back().n_rpm * rad_per_s);
    }
    sample.uc_v = Convert(u, profile.converters.range_v);
    schedule.Apply(sample.t_s, plant);
    plant.SetInput(sample.uc_v);
    plant.Advance(profile.delta_s);
    Acquire(plant.outputs(), profile.converters, bench.nominal.gear_ratio, noise, sample);
    if (profile.converters.counts) {
      sample.n_rpm = counter.Rpm(plant.outputs().angle_rad, bench.period_s);
    }
    plant.Advance(bench.period_s - profile.delta_s);
    record.samples.push_back(sample);
    record.reference_rad_s.push_back(reference);
    record.speed_rad_s.push_back(plant.outputs().omega_rad_s);
    pipeline.Push(sample);
    while (std::optional<DiagnosisTask> task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
    if (!drive) continue;
    if (drive->gave_up() && !record.gave_up_at_s) record.gave_up_at_s = sample.t_s;
    const bool tell = plan.told && !told && sample.t_s >= plan.told->at_s;
    if (!tell && (told || pipeline.verdict_version() == heard)) continue;
    heard = pipeline.verdict_version();
    told = tell;
    drive->Heard(tell        ? VerdictOf(*plan.told)
                 : plan.told ? WithoutName(pipeline.verdict())
                             : pipeline.verdict());
    if (drive->compensates() && !record.compensated_at_s) record.compensated_at_s = sample.t_s;
  }
  record.verdict = pipeline.verdict();
  record.reachable_rad_s = drive->reachable_rad_s();
  record.accommodated = record.reachable_rad_s >= std::max(plan.low_rad_s, plan.high_rad_s);
  double from_s = control_from_s + kRunInS;
  if (!plan.faults.empty()) {
    from_s = std::max(control_from_s, std::ranges::min(plan.faults, {}, &Fault::at_s).at_s);
  }
  record.quality = QualityOf(plan, record, from_s);
  return record;
}

}  // namespace faultlab::core
