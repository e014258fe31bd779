#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/csv/csv_channels.h"

namespace faultlab::server {

/// The meaning of one cell of a header.
struct CsvColumn {
  const CsvChannel* channel = nullptr;  ///< nullptr: not a column of a recording
  double factor = 1.0;                  ///< from the file's unit to the channel's
  bool has_unit = false;                ///< the name contains the unit
  bool either = false;                  ///< a voltage of which the name does not say whose
  bool unit_alone = false;              ///< the name is its unit: "ms"
  bool angular = false;                 ///< an angular speed: 1/s is rad/s
  bool adds = false;                    ///< one of two cells whose sum it is: seconds, nanoseconds
  /// How far the name is from the channel's plain one, which is 0: of two for one channel the
  /// nearer one is taken.
  int distance = 0;
  std::string unknown_unit;  ///< of a known channel; empty if the unit fits

  // Of what is no column of a recording.
  const CsvChannel* unit_of = nullptr;  ///< whose unit it has
  bool position = false;                ///< an angle, or counts of an encoder
};

/// Reads a name as people write it, "Uc [V]", "ia/mA", "Geschwindigkeit gemessen (U/min)": words of
/// several languages that name what is measured, words that say where or how, and a unit. One word
/// that is neither makes it a column of something else. csv_words.h lists the words and units.
CsvColumn ParseColumnName(std::string_view cell);

/// Factor of a unit, "V" or "[V]", to that of the column's channel; nothing when it does not fit
/// it.
std::optional<double> UnitFactor(const CsvColumn& column, std::string_view unit);

/// For a message: "V or mV".
std::string_view UnitsOf(const CsvChannel& channel);

}  // namespace faultlab::server
