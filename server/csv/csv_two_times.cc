#include "server/csv/csv_two_times.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace faultlab::server {

std::optional<std::string> TellTwoTimes(LineCursor rows,
                                        char separator,
                                        std::vector<CsvColumn>& columns) {
  std::vector<std::size_t> parts;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].adds) parts.push_back(i);
  }
  if (parts.size() != 2) return std::nullopt;
  if (columns[parts[0]].factor != 1.0) std::swap(parts[0], parts[1]);
  while (const std::optional<std::string_view> line = rows.Next()) {
    std::string_view rest = *line;
    std::size_t cell = 0;
    for (bool more = true; more; ++cell) {
      const auto number = ParseCell(separator, TakeCell(separator, rest, more));
      const bool whole = !number || *number == std::floor(*number);
      const bool less = !number || std::abs(*number * columns[parts[1]].factor) < 1.0;
      if ((cell != parts[0] || whole) && (cell != parts[1] || less)) continue;
      columns[parts[0]].adds = false;
      columns[parts[1]] = {};
      return "of two columns of time the one in seconds was taken";
    }
  }
  return std::nullopt;
}

}  // namespace faultlab::server
