#include "core/control/closed_loop/control_replay.h"

#include "core/control/closed_loop/orders.h"
#include "core/plant/simulate_record.h"
#include "core/types/check.h"

namespace faultlab::core {

std::vector<Sample> WithoutCompensation(const ControlledRecord& record) {
  LAB_CHECK(record.bench != nullptr && record.profile != nullptr);
  LAB_CHECK(record.began > 0 && record.reference_from <= record.began, record.began);
  const Bench& bench = *record.bench;
  const double rad_per_s = RadPerSecondOfRpm(bench.nominal.gear_ratio);
  RecordSimulator rig(*record.profile, bench.nominal, record.faults, record.seed, record.period_s);
  const ReferencePlayer reference(record.reference, record.period_s);
  std::vector<Sample> out;
  out.reserve(record.uc_v.size());
  for (std::size_t k = 0; k < record.uc_v.size() && k < record.began; ++k) {
    out.push_back(rig.Step(record.uc_v[k]));
  }
  if (out.size() < record.began) return out;
  TolerantDrive drive(bench.limits,
                      OrderOf(bench, record.calibration, {}, record.period_s),
                      record.period_s,
                      {.kind = ControlKind::kNominal},
                      out.back().uc_v);
  for (std::size_t k = record.began; k < record.uc_v.size(); ++k) {
    const double wanted_rad_s = reference.At(k - record.reference_from);
    out.push_back(rig.Step(drive.Tick(wanted_rad_s, out.back().n_rpm * rad_per_s)));
  }
  return out;
}

}  // namespace faultlab::core
