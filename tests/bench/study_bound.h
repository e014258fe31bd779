#pragma once

#include <span>
#include <vector>

#include "core/filter/rig_parameters.h"
#include "core/types/fault.h"
#include "core/types/sample.h"

namespace faultlab::study {

/// Cramer-Rao bound of log(fault value): the standard error that no unbiased estimator can beat on
/// this record, with its healthy and faulty parts together, when the rig is known within its data
/// sheet's tolerances (those of the calibration) and the noise exactly. Computed from the
/// innovations of the true model, with sensitivities by differences; the onset is taken as known.
double CramerRaoSd(const core::RigParameters& rig,
                   const core::NoiseLevel& noise,
                   const core::Fault& fault,
                   std::span<const core::Sample> record,
                   core::Channels channels);

}  // namespace faultlab::study
