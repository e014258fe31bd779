#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/fault.h"

namespace faultlab::hardware {

/// The smallest and the largest value of a signal in a run.
struct SignalSpan {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  void Include(double value) {
    min = value < min ? value : min;
    max = value > max ? value : max;
  }
};

/// One signal, and the band in which it is what the models take it for.
struct SignalForecast {
  std::string name;             ///< "um"
  std::string unit;             ///< "V"
  SignalSpan reaches;           ///< without noise
  SignalSpan may;               ///< infinite where nothing ends it
  const char* bounded_by = "";  ///< "its converter reads"
  bool in_use = true;           ///< false: a channel that the bench does not measure

  /// Up to rounding.
  bool fits() const {
    constexpr double kRounding = 1e-9;
    return !in_use || (reaches.min >= may.min - kRounding && reaches.max <= may.max + kRounding);
  }
};

/// Why a run does not go through, or not with all its readings.
struct RunProblem {
  std::string about;  ///< the same for the same reason: "um its converter reads", "over_heat"
  std::string text;   ///< a sentence with figures
};

/// What a run of one rig under one input would be, before anything is built.
struct RunForecast {
  /// uc against its range, its terminal against the converter, the output against the supply, and
  /// each measured channel against its converter.
  std::vector<SignalForecast> signals;
  std::vector<RunProblem> problems;  ///< none: the run goes through
};

/// Plays `uc_v`, the usual excitation with some seed, on the described rig with one fault from its
/// first sample on, or none. The signals are those of an amplifier and of converters without ends,
/// so that the figures say by how much; trips are those of the usual simulator with all its ends.
/// Deterministic, without noise. 20 s at 100 Hz take some milliseconds. Contract: `uc_v` is finite
/// and not empty.
RunForecast ForecastRun(const core::Bench& bench,
                        std::span<const double> uc_v,
                        const std::optional<core::Fault>& fault = std::nullopt);

}  // namespace faultlab::hardware
