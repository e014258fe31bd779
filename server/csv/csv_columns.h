#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/csv/csv_header.h"

namespace faultlab::server {

/// The line of names, and where it stands.
struct NamesLine {
  std::string_view text;
  char separator = ',';
  std::string_view file;     ///< for messages
  std::uint32_t number = 0;  ///< of the line in the file, from 1
  std::string without_time;  ///< for the end of a message that there is no time; may be empty
};

/// What the cells of a row are.
struct CsvColumns {
  std::vector<CsvColumn> cells;        ///< by place; channel is null where something else stands
  std::vector<std::string> channels;   ///< names, in the order of kCsvChannelTable
  std::vector<std::string> notes;      ///< what was read otherwise than it is written
  std::vector<std::string> questions;  ///< those of columns that could be what the file lacks
};

/// For messages: the columns of a recording.
inline constexpr std::string_view kColumnsWanted =
    "t_s, uc_v, um_v (or ia_a, or n_rpm, where a bench is diagnosed by it) and any of ua_v, ia_a, "
    "n_rpm, separated by commas";

/// Refuses a line without what a recording must have, saying what each cell was taken for.
core::Result<CsvColumns> ReadColumns(const NamesLine& names);

/// That the line contains no names.
core::Error NoHeader(const NamesLine& first);

/// A second line of a header that contains units, "s;V;V": they become those of `cells`.
/// @returns false, and changes nothing, when the line is none; an error for a unit that is not
/// known
core::Result<bool> TakeUnits(const NamesLine& line, std::vector<CsvColumn>& cells);

}  // namespace faultlab::server
