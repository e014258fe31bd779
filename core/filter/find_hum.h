#pragma once

#include <span>

#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"
#include "core/types/hum.h"

namespace faultlab::core {

/// What a frequency must explain, in chi-square, where nobody knows of hum. In white noise the best
/// of the scan explained at most 31 in 3000 simulated stretches of 450 samples.
inline constexpr double kHumGainMin = 45.0;

/// The hum of the mains in a stretch: the frequency within 0.5 Hz of 50 or 60 Hz whose
/// sinusoid explains the innovations of `model` best, and the phasors by their exact response in
/// the filter. Outliers count no more than four robust standard deviations, so that strong hum is
/// found before impulses are looked for. No answer (Hum::any() false): no voltage or current was
/// read; nothing stands out of the noise; a rate at which mains hum looks like a constant or a slow
/// drift.
/// @param t_s  run times of the observations
/// Cost: some 2 ms for 1000 samples.
Hum FindHum(const PredictionModel& model,
            std::span<const Observation> stretch,
            std::span<const double> t_s,
            double period_s,
            double gain_min = kHumGainMin);

}  // namespace faultlab::core
