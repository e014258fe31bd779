#pragma once

#include <span>
#include <string_view>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/plots/figures.h"

namespace faultlab::server {

/// The figure of a whole recording by its name (kFigureNames), for the command line and for HTTP.
/// The estimates drawn are bit-equal to those that were streamed. Verdict and nominal lines that
/// are not in `context` come from the diagnosis.
/// Errors: kNotFound for an unknown name; kInvalid for a record of fewer than two samples.
/// Cost: about 3 us a sample and the fits of the diagnosis.
core::Result<Figure> MakeFigure(std::string_view name,
                                std::span<const core::Sample> samples,
                                const core::DiagnosisOptions& options,
                                FigureContext context);
/// The same with an existing diagnosis of the record, made live or by DiagnoseRecord with these
/// options: nothing is fitted again.
core::Result<Figure> MakeFigure(std::string_view name,
                                std::span<const core::Sample> samples,
                                const core::DiagnosisOptions& options,
                                const core::Diagnosis& diagnosis,
                                FigureContext context);
/// "signals, swa, ..".
std::string FigureList();
/// kNotFound unless `name` is one of kFigureNames, kInvalid for fewer than two samples.
core::Status CheckFigure(std::string_view name, std::span<const core::Sample> samples);

/// Simulated outputs and the measurement after the fault (paper Tables 13-20): the last SWA and SIA
/// estimates, Eq. 3 with Mc = 0, 0.33, 0.48 mNm at the estimated value, and the calibrated sampled
/// plant at that value. Empty when the record has no unbroken stretch of 2 s there.
ModelComparison CompareModels(std::span<const core::Sample> samples,
                              const core::DiagnosisOptions& options,
                              const core::Diagnosis& diagnosis);

/// Stores the fit of each of CompareModels' models in diagnosis.fit_percent under its key.
void AddModelFits(std::span<const core::Sample> samples,
                  const core::DiagnosisOptions& options,
                  core::Diagnosis& diagnosis);

}  // namespace faultlab::server
