#include "server/csv/csv_text.h"

#include <algorithm>
#include <array>
#include <charconv>
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
  const std::size_t end = separator == ' ' ? rest.find_first_of(" \t") : rest.find(separator);
  const std::string_view cell = rest.substr(0, end);
  more = end != std::string_view::npos;
  rest.remove_prefix(more ? end + 1 : rest.size());
  return Trim(cell);
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
