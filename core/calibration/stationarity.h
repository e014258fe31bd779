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
  /// The same of what warms up (kWarmingParts), fitted together, and the largest score of a
  /// coordinate that is left when these have moved from piece to piece.
  using Walk = std::array<double, 3>;
  std::array<Walk, kQuarters> walk_shift{};
  double beyond_walk = 0.0;
  /// Squared normal score of the way from the first quarter to the last where they go on in one
  /// direction, from each quarter to the next; 0 where they do not.
  double drift = 0.0;
  /// The largest share of its residual energy that a quarter has, times four.
  double energy = 0.0;

  /// From the first quarter to the last.
  double change() const { return shift.back() - shift.front(); }
  Walk walk() const;
};

/// @param coordinates  how many of them are looked at
/// @param warming  BenchNorm::warming
/// Cost: four passes of the filter, and one for each coordinate.
Stationarity StationarityOf(const RigParameters& rig,
                            const NoiseLevel& noise,
                            double period_s,
                            std::span<const Observation> stretch,
                            std::size_t coordinates,
                            double warming);

}  // namespace faultlab::core
