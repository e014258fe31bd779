#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/csv/csv_header.h"
#include "server/csv/csv_text.h"

namespace faultlab::server {

/// "sec" and "nanosec" are parts of one time where the seconds are whole and the others less than
/// one; else they are two times, and the finer one is left out of `columns`.
/// @param rows  the lines below the names
/// @returns what to note; nothing when nothing was left out
std::optional<std::string> TellTwoTimes(LineCursor rows,
                                        char separator,
                                        std::vector<CsvColumn>& columns);

}  // namespace faultlab::server
