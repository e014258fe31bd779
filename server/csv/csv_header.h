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
  bool either = false;                  ///< "voltage": uc_v, unless it is the motor's
  std::string unknown_unit;             ///< of a known channel; empty if the unit fits
};

/// Parses names as people write them: the plain "um_v", and, in any case, a name followed by a
/// unit: "Uc [V]", "um(mV)", "ia/mA", "speed_rpm", "time ms", "t". csv_header.cc lists names and
/// units.
CsvColumn ParseColumnName(std::string_view cell);

/// Factor of a unit to the channel's own; nothing when the unit does not fit the channel.
std::optional<double> UnitFactor(const CsvChannel& channel, std::string_view unit);

/// For a message: "V or mV".
std::string_view UnitsOf(const CsvChannel& channel);

/// The separator of the cells: ';' or a tab if the line contains one outside of quotes, otherwise
/// ','. A line without
/// any of them but with blanks between its words is separated by blanks (' ').
char FindSeparator(std::string_view header);

}  // namespace faultlab::server
