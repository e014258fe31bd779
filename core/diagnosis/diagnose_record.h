#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/types/frame.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// Diagnoses a whole record with the pipeline of a live run; its tasks are run at once, on this
/// thread.
/// @param told  may be empty; gets each new verdict with the index of the sample that led to it,
///              and the last one once more
Diagnosis DiagnoseRecord(
    std::span<const Sample> samples,
    const DiagnosisOptions& options,
    const std::function<void(const Verdict& verdict, std::int64_t index)>& told = {});

/// Where the healthy stretch does not fit its bench: says in the reason which of `others` it fits,
/// if it fits one. Cost: a calibration for each, at most ten of them.
void SuggestBench(std::span<const Sample> samples,
                  const DiagnosisOptions& options,
                  std::span<const Bench* const> others,
                  Diagnosis& diagnosis);

/// The estimates of a record, in order, once per sample: bit-equal to those of a live run with
/// these options.
void ReplayEstimates(std::span<const Sample> samples,
                     const DiagnosisOptions& options,
                     const std::function<void(const Frame&)>& each);

}  // namespace faultlab::core
