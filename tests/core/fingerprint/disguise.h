#pragma once

#include <cstddef>
#include <vector>

#include "core/signals/random.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// How somebody may change a record before they bring it to the lab as their own. Written before
/// the search that must find it again.
struct Disguise {
  std::size_t from = 0;        ///< the first sample that is kept
  std::size_t samples = 200;   ///< how many
  double rate = 1.0;           ///< samples of the original per sample of the copy
  double scale = 1.0;          ///< of all readings, after which `offset` is added
  double command_scale = 1.0;  ///< of uc
  double offset = 0.0;         ///< as a share of a channel's span
  double noise = 0.0;          ///< added white noise, in the channel's own standard deviations
  int bits = 0;                ///< of the span of each channel; 0: not rounded
  int outliers = 0;            ///< readings replaced by the end of the span
  bool um_alone = false;       ///< of the measured channels
};

/// White noise of a bench's channels, in the order um, ua, ia, n.
using OwnNoise = std::vector<double>;

/// The samples as the disguise shows them, counted from 0 with the period of the original.
std::vector<Sample> Dress(const std::vector<Sample>& record,
                          const Disguise& disguise,
                          const OwnNoise& own,
                          double period_s,
                          Random& random);

/// A disguise drawn at random: each of its parts is there with probability one half.
/// @param strength  0: only cut; 1: resampled within 5 %, 8 bits, noise of twice its own
Disguise DrawDisguise(std::size_t record, std::size_t samples, double strength, Random& random);

}  // namespace faultlab::core
