#include "core/diagnosis/diagnosis_task.h"

#include <utility>

namespace faultlab::core {
namespace {

CalibrationResult RunCalibration(const CalibrationTask& task) {
  CalibrationResult result;
  result.id = task.id;
  Result<Calibration> calibration = Calibrate(task.samples, task.options);
  if (calibration.ok()) {
    result.calibration = std::make_shared<const Calibration>(std::move(calibration.value()));
  } else {
    result.refusal = calibration.error();
  }
  return result;
}

}  // namespace

CalibrationOptions CalibrationOf(const DiagnosisOptions& options) {
  return {.bench = options.bench,
          .data_sheet = options.nominal,
          .channels = options.channels,
          .period_s = options.period_s,
          .false_alarms_per_day = options.false_alarms_per_day,
          .um_rail_v = options.um_rail_v,
          .model = options.model};
}

DiagnosisResult RunTask(const DiagnosisTask& task) {
  if (const auto* calibration = std::get_if<CalibrationTask>(&task)) {
    return RunCalibration(*calibration);
  }
  return Isolate(std::get<IsolationTask>(task));
}

DiagnosisResult Unanswered(const DiagnosisTask& task, Error error) {
  if (const auto* calibration = std::get_if<CalibrationTask>(&task)) {
    CalibrationResult result;
    result.id = calibration->id;
    result.refusal = std::move(error);
    return result;
  }
  IsolationResult result;
  result.id = std::get<IsolationTask>(task).id;
  return result;
}

}  // namespace faultlab::core
