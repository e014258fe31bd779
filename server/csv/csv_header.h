#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/csv/csv_channels.h"

namespace faultlab::server {

/// What one cell of a header names.
struct CsvColumn {
  const CsvChannel* channel = nullptr;  ///< nullptr: not a column of a recording
  double factor = 1.0;                  ///< from the file's unit to the channel's
  bool has_unit = false;                ///< the name says which unit
  std::string unknown_unit;             ///< not empty: a known channel in a unit that is not
};

/// Reads names as people write them: the plain "um_v", and any case of a name with a unit behind
/// it, "Uc [V]", "um(mV)", "ia/mA", "speed_rpm", "time ms", "t". See csv_header.cc for both lists.
CsvColumn ParseColumnName(std::string_view cell);

/// Factor of a unit to the channel's own; nothing when the unit does not fit the channel.
std::optional<double> UnitFactor(const CsvChannel& channel, std::string_view unit);

/// What stands between the cells: ';' or a tab when the line has one, else ','. A line without any
/// of them but with blanks between its words is separated by blanks (' ').
char FindSeparator(std::string_view header);

}  // namespace faultlab::server
