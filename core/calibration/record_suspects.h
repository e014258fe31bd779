#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/sample.h"

namespace faultlab::core {

struct Channel {
  const char* name;
  double Sample::*reading;
};
inline constexpr Channel kUc = {"uc", &Sample::uc_v};
inline constexpr Channel kUm = {"um", &Sample::um_v};
inline constexpr Channel kIa = {"ia", &Sample::ia_a};
inline constexpr Channel kN = {"n", &Sample::n_rpm};

/// Something that is wrong with a record, and what is done about it.
struct Suspect {
  std::vector<const Channel*> channels;  ///< with it; none: all readings
  double factor = 1.0;
  int rows = 0;  ///< so much later than it should be
  std::string sentence;
  double taken = 0.0;   ///< volts of uc, whatever it is
  double of_new = 1.0;  ///< y += of_new * (reading - y) has smoothed it
  int mean_rows = 1;    ///< it is a mean of the last so many
};

/// Those without a number of their own: units, signs, sides of the gear, rows too late.
std::vector<Suspect> SuspectsOf(const Bench& bench);

/// Readings that are too late alone, or smoothed: of all, of one channel, or of ia and n.
std::vector<std::vector<const Channel*>> GroupsOf(std::span<const Sample> samples);

/// Smoothed as by y += of_new (x - y), in the program that recorded it.
Suspect SmoothedBy(std::vector<const Channel*> channels, double of_new, double period_s);

/// The same as a mean of the last rows.
Suspect MeanOf(std::vector<const Channel*> channels, int rows, double period_s);

/// A bridge of bipolar transistors takes a constant voltage of what it is told.
Suspect TakenBy(double taken_v, bool reads_current);

/// Whether each channel of the suspect has readings.
bool AreRead(const std::vector<const Channel*>& channels, std::span<const Sample> samples);

/// The record as it would be without what is wrong.
std::vector<Sample> Mended(std::span<const Sample> samples, const Suspect& suspect);

}  // namespace faultlab::core
