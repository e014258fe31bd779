#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/isolation/isolation.h"
#include "core/types/calibration.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The calibration that a diagnosis with these options makes.
CalibrationOptions CalibrationOf(const DiagnosisOptions& options);

/// Estimates the parameters of the rig from the fault-free stretch of a run.
struct CalibrationTask {
  std::uint64_t id = 0;         ///< copied to CalibrationResult
  std::vector<Sample> samples;  ///< the stretch
  CalibrationOptions options;
};

struct CalibrationResult {
  std::uint64_t id = 0;
  std::shared_ptr<const Calibration> calibration;  ///< null when refused
  std::optional<Error> refusal;                    ///< which check failed
};

/// Work that Pipeline hands out because it takes milliseconds. A self-contained value: move it to
/// any thread, call RunTask, and bring the result back with Pipeline::Accept.
using DiagnosisTask = std::variant<CalibrationTask, IsolationTask>;
using DiagnosisResult = std::variant<CalibrationResult, IsolationResult>;

/// Pure function of the task; any thread.
/// CPU time: see Calibrate and Isolate.
DiagnosisResult RunTask(const DiagnosisTask& task);

/// The result of a task whose computation failed: a calibration is refused with `error`, an
/// isolation gives no answer.
DiagnosisResult Unanswered(const DiagnosisTask& task, Error error);

}  // namespace faultlab::core
