#pragma once

#include <functional>
#include <span>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/types/frame.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// Diagnoses a whole record with the pipeline of a live run; its tasks are run at once, on this
/// thread.
Diagnosis DiagnoseRecord(std::span<const Sample> samples, const DiagnosisOptions& options);

/// The estimates of a record, in order, once per sample: bit-equal to those of a live run with
/// these options.
void ReplayEstimates(std::span<const Sample> samples,
                     const DiagnosisOptions& options,
                     const std::function<void(const Frame&)>& each);

}  // namespace faultlab::core
