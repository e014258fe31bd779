#include "server/csv/csv_decimal_marks.h"

#include "server/csv/csv_text.h"

namespace faultlab::server {

void DecimalMarks::See(std::string_view cell) {
  const std::size_t at = cell.find_first_of(".,");
  if (at == std::string_view::npos || cell.find_first_of(".,", at + 1) != std::string_view::npos) {
    return;
  }
  const std::size_t digits = cell.size() - at - 1;
  const std::size_t before = cell.find_first_of("123456789");
  const bool thousands = digits == 3 && before < at && at - before <= 3;
  std::string& first = (cell[at] == '.' ? (thousands ? points_of_thousands_ : points_)
                                        : (thousands ? commas_of_thousands_ : commas_));
  if (first.empty()) first = cell;
}

std::string DecimalMarks::SayTwoMarks() const {
  const bool point = !points_of_thousands_.empty() && points_.empty() && !commas_.empty();
  const bool comma = !commas_of_thousands_.empty() && commas_.empty() && !points_.empty();
  const bool either = !points_of_thousands_.empty() && !commas_of_thousands_.empty() &&
                      points_.empty() && commas_.empty();
  if (!point && !comma && !either) return "";
  const std::string& one = point ? commas_ : comma ? points_ : points_of_thousands_;
  return "'" + Shown(one) + "' and '" + Shown(point ? points_of_thousands_ : commas_of_thousands_) +
         "' are of one file: is the mark of the second one of thousands? Write numbers without "
         "marks of thousands";
}

}  // namespace faultlab::server
