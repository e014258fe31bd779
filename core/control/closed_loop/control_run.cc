#include "core/control/closed_loop/control_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/control/closed_loop/orders.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/diagnosis/pipeline.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr double kSecondsMax = 3600.0;

Error Wrong(std::string message, std::string field) {
  return {ErrorCode::kInvalid, std::move(message), std::move(field), "internal"};
}

std::size_t TicksOf(const ControlPlan& plan, double seconds) {
  return static_cast<std::size_t>(std::lround(seconds / plan.bench->period_s));
}

Status Check(const ControlPlan& plan) {
  const Bench& bench = *plan.bench;
  if (!bench.n.exists) return Wrong("the bench " + bench.name + " does not measure n", "bench");
  if (const Status good = Validate(plan.reference, bench.period_s); !good) return good;
  if (!(plan.duration_s > 0.0 && plan.duration_s <= kSecondsMax)) {
    return Wrong("a run lasts an hour at most", "duration_s");
  }
  return Done{};
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
  const double control_from_s = options.healthy_to_s + kControlAfterLearningS;
  TRY(const auto learning, Generate(bench.excitation, control_from_s, bench.period_s));
  const std::size_t ticks = TicksOf(plan, plan.duration_s);
  if (ticks <= learning.size()) {
    return Wrong("the run ends before the rig is learnt", "duration_s");
  }

  RecordSimulator rig(
      bench.profiles.front(), bench.nominal, plan.faults, plan.seed, bench.period_s);
  Pipeline pipeline(options);
  const ReferencePlayer player(plan.reference, bench.period_s);
  std::optional<TolerantDrive> drive;
  const double rad_per_s = RadPerSecondOfRpm(bench.nominal.gear_ratio);

  ControlRecord record;
  record.control_from_s = control_from_s;
  std::uint64_t heard = 0;
  bool told = false;
  for (std::size_t k = 0; k < ticks; ++k) {
    double reference = std::numeric_limits<double>::quiet_NaN();
    double u = 0.0;
    if (k < learning.size()) {
      u = learning[k];
    } else {
      if (!drive) {
        const auto calibration = pipeline.calibration();
        if (!calibration) return Wrong(pipeline.verdict().reason, "bench");
        const ControlOrder order = OrderOf(bench, *calibration, {}, bench.period_s);
        record.dither_rad_s = plan.options.dither_v * order.healthy.speed.RipplePerVolt();
        drive.emplace(
            bench.limits, order, bench.period_s, plan.options, record.samples.back().uc_v);
        const double highest = plan.reference.highest();
        if (highest > drive->reachable_rad_s()) {
          return Wrong("the healthy rig reaches " + std::to_string(drive->reachable_rad_s()) +
                           " rad/s, the reference asks for " + std::to_string(highest),
                       "reference");
        }
        heard = pipeline.verdict_version();
      }
      reference = player.At(k - learning.size());
      u = drive->Tick(reference, record.samples.back().n_rpm * rad_per_s);
    }
    const Sample sample = rig.Step(u);
    record.samples.push_back(sample);
    record.reference_rad_s.push_back(reference);
    record.speed_rad_s.push_back(rig.speed_rad_s());
    pipeline.Push(sample);
    while (std::optional<DiagnosisTask> task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
    if (!drive) continue;
    if (drive->gave_up() && !record.gave_up_at_s) record.gave_up_at_s = sample.t_s;
    const bool tell = plan.told && !told && sample.t_s >= plan.told->at_s;
    if (!tell && (told || pipeline.verdict_version() == heard)) continue;
    heard = pipeline.verdict_version();
    told = tell;
    const Verdict verdict = tell        ? VerdictOf(*plan.told)
                            : plan.told ? WithoutName(pipeline.verdict())
                                        : pipeline.verdict();
    drive->Heard(OrderOf(bench, *pipeline.calibration(), verdict, bench.period_s));
    if (drive->compensates() && !record.compensated_at_s) record.compensated_at_s = sample.t_s;
  }
  record.verdict = pipeline.verdict();
  record.reachable_rad_s = drive->reachable_rad_s();
  record.accommodated = record.reachable_rad_s >= plan.reference.highest();
  double from_s = control_from_s + kControlRunInS;
  if (!plan.faults.empty()) {
    from_s = std::max(control_from_s, std::ranges::min(plan.faults, {}, &Fault::at_s).at_s);
  }
  record.quality = QualityOf(plan.reference,
                             {.reference_rad_s = record.reference_rad_s,
                              .speed_rad_s = record.speed_rad_s,
                              .control_from = TicksOf(plan, control_from_s),
                              .from = TicksOf(plan, from_s),
                              .period_s = bench.period_s});
  return record;
}

}  // namespace faultlab::core
