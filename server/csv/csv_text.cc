#include "server/csv/csv_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>

namespace faultlab::server {
namespace {

constexpr std::size_t kShownCellBytes = 24;

/// Converts a cell with a decimal comma to the form that from_chars needs; false when it is longer
/// than any number or contains thousands separators.
class PointNumber {
 public:
  bool Set(std::string_view cell) {
    if (cell.size() > text_.size() || cell.find('.') != std::string_view::npos ||
        cell.find(',') != cell.rfind(',')) {
      return false;
    }
    std::replace_copy(cell.begin(), cell.end(), text_.begin(), ',', '.');
    size_ = cell.size();
    return true;
  }
  std::string_view view() const { return {text_.data(), size_}; }

 private:
  std::array<char, 40> text_;
  std::size_t size_ = 0;
};

}  // namespace

std::string_view Trim(std::string_view cell) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!cell.empty() && blank(cell.front())) {
    cell.remove_prefix(1);
  }
  while (!cell.empty() && blank(cell.back())) {
    cell.remove_suffix(1);
  }
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') {
    cell = cell.substr(1, cell.size() - 2);
  }
  return cell;
}

std::string Shown(std::string_view cell) {
  std::string shown(cell.substr(0, kShownCellBytes));
  std::replace_if(
      shown.begin(),
      shown.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; },
      '?');
  return cell.size() > kShownCellBytes ? shown + ".." : shown;
}

std::string_view TakeCell(char separator, std::string_view& rest, bool& more) {
  if (separator == ' ') {
    rest = Trim(rest);
  }
  std::size_t from = 0;
  if (const std::size_t first = rest.find_first_not_of(" \t");
      first != std::string_view::npos && rest[first] == '"') {
    // The quote that ends the cell stands alone: two are one in the text.
    for (from = first + 1; from < rest.size(); ++from) {
      if (rest[from] != '"') continue;
      if (rest.substr(from + 1, 1) != "\"") break;
      ++from;
    }
  }
  const std::size_t end =
      separator == ' ' ? rest.find_first_of(" \t", from) : rest.find(separator, from);
  const std::string_view cell = rest.substr(0, end);
  more = end != std::string_view::npos;
  rest.remove_prefix(more ? end + 1 : rest.size());
  return Trim(cell);
}

bool IsAbsent(std::string_view cell) {
  constexpr std::array<std::string_view, 8> kAbsent = {
      "", "-", "--", "NA", "N/A", "n/a", "null", "NULL"};
  return std::ranges::find(kAbsent, cell) != kAbsent.end();
}

std::optional<double> ParseClock(char separator, std::string_view cell) {
  double days = 0.0;
  if (const std::size_t at = cell.find_first_of("T "); at == 10) {
    int year = 0;
    int month = 0;
    int day = 0;
    const auto whole = [&](std::size_t from, std::size_t size, int& to) {
      const char* const end = cell.data() + from + size;
      return std::from_chars(cell.data() + from, end, to).ptr == end;
    };
    if (!whole(0, 4, year) || !whole(5, 2, month) || !whole(8, 2, day)) return std::nullopt;
    const std::chrono::year_month_day date{std::chrono::year(year),
                                           std::chrono::month(static_cast<unsigned>(month)),
                                           std::chrono::day(static_cast<unsigned>(day))};
    if (month < 1 || day < 1 || !date.ok()) return std::nullopt;
    days = static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
    cell.remove_prefix(11);
    if (cell.ends_with('Z')) cell.remove_suffix(1);
  }
  const std::size_t first = cell.find(':');
  const std::size_t second = cell.find(':', std::min(first, cell.size() - 1) + 1);
  if (first == std::string_view::npos || second == std::string_view::npos) return std::nullopt;
  const auto hours = ParseCell(separator, cell.substr(0, first));
  const auto minutes = ParseCell(separator, cell.substr(first + 1, second - first - 1));
  const auto seconds = ParseCell(separator, cell.substr(second + 1));
  if (!hours || !minutes || !seconds) return std::nullopt;
  const auto fits = [](double value, double most) { return value >= 0.0 && value < most; };
  if (!fits(*hours, 25.0) || !fits(*minutes, 60.0) || !fits(*seconds, 61.0)) return std::nullopt;
  return 86'400.0 * days + 3600.0 * *hours + 60.0 * *minutes + *seconds;
}

std::optional<double> ParseCell(char separator, std::string_view cell) {
  PointNumber point;
  if (separator != ',' && cell.find(',') != std::string_view::npos) {
    if (!point.Set(cell)) {
      return std::nullopt;
    }
    cell = point.view();
  }
  if (cell.starts_with('+')) {
    cell.remove_prefix(1);
  }
  double value = 0.0;
  const std::from_chars_result read =
      std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (read.ec != std::errc() || read.ptr != cell.data() + cell.size() || std::isinf(value)) {
    return std::nullopt;
  }
  return value;
}

}  // namespace faultlab::server
