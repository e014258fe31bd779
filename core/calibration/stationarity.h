#pragma once

#include <array>
#include <span>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// How far the rig differs between the quarters of a stretch from which it was learnt. What
/// scatters from one piece of a quarter to the next is no change: a score is in units of that
/// scatter, or of the noise where that is more (H. White, Econometrica 48 (1980)).
struct Stationarity {
  static constexpr int kQuarters = 4;
  double score = 0.0;  ///< the largest squared normal score of a coordinate in a quarter
  int coordinate = 0;  ///< of that score
  /// By how much that coordinate is more in each quarter than in the whole stretch, in its units.
  std::array<double, kQuarters> shift{};
  /// The same of Ra, and the largest score that is left when Ra alone has moved so.
  std::array<double, kQuarters> ra_shift{};
  double beyond_ra = 0.0;
  /// The largest share of its residual energy that a quarter has, times four.
  double energy = 0.0;

  /// From the first quarter to the last.
  double change() const { return shift.back() - shift.front(); }
  double ra_change() const { return ra_shift.back() - ra_shift.front(); }
  /// Ra goes on in one direction, and nothing else changes.
  bool ra_drifts() const;
};

/// @param coordinates  how many of them are looked at
/// Cost: one pass of the filter for each coordinate.
Stationarity StationarityOf(const RigParameters& rig,
                            const NoiseLevel& noise,
                            double period_s,
                            std::span<const Observation> stretch,
                            std::size_t coordinates);

}  // namespace faultlab::core
