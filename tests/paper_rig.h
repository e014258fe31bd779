#pragma once

#include "core/calibration/bench_noise.h"
#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/filter/rig_parameters.h"
#include "tests/paper_bench.h"

/// Options and models of a rig of the paper's bench, for tests.
namespace faultlab::paper {

inline constexpr double kRadPerSecondOfRpm = core::RadPerSecondOfRpm(kGearRatio);

/// A healthy rig without friction except the viscous one.
inline core::RigParameters Rig() {
  return {Plant(), 1.0, Bench().delta_s, 0.0};
}

inline core::NoiseLevel Noise() {
  return core::NoiseOf(Bench());
}

inline core::DiagnosisOptions Options() {
  return core::OptionsOf(Bench());
}

inline core::CalibrationOptions ToCalibrate() {
  core::CalibrationOptions options;
  options.bench = &Bench();
  options.data_sheet = Plant();
  return options;
}

inline core::IsolationOptions ToIsolate() {
  core::IsolationOptions options;
  options.bench = &Bench();
  return options;
}

}  // namespace faultlab::paper
