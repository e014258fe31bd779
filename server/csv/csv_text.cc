#include "server/csv/csv_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>

#include "core/types/utf8.h"

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
    while (!cell.empty() && (cell.back() == '\n' || cell.back() == '\r')) cell.remove_suffix(1);
  }
  return cell;
}

bool BeginsWith(std::string_view text, std::string_view lower_case) {
  return text.size() >= lower_case.size() &&
         std::equal(lower_case.begin(), lower_case.end(), text.begin(), [](char a, char b) {
           return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
         });
}

std::size_t LineCursor::EndOfLine() const {
  constexpr int kLinesOfCellMax = 10;
  const auto find_end = [this](std::size_t from) {
    return std::min(rest_.find('\n', from), rest_.size());
  };
  const std::size_t first = find_end(0);
  if (rest_.starts_with('#')) return first;
  const auto is_open = [this](std::size_t end) {
    return std::ranges::count(rest_.substr(0, end), '"') % 2 != 0;
  };
  std::size_t end = first;
  for (int lines = 1; end < rest_.size() && is_open(end); ++lines) {
    if (lines == kLinesOfCellMax) return first;
    end = find_end(end + 1);
  }
  return is_open(end) ? first : end;
}

std::string Shown(std::string_view cell) {
  std::string shown(core::CutUtf8(cell, kShownCellBytes));
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
  constexpr std::array<std::string_view, 10> kAbsent = {
      "", "-", "--", "---", "None", "NA", "N/A", "n/a", "null", "NULL"};
  return std::ranges::find(kAbsent, cell) != kAbsent.end();
}

namespace {

constexpr double kDay_s = 86'400.0;

/// Seconds of "+02:00", "-0330", "+01".
std::optional<double> ZoneOf(std::string_view zone) {
  std::string digits(zone.substr(1));
  std::erase(digits, ':');
  int number = 0;
  const char* const end = digits.data() + digits.size();
  if (std::from_chars(digits.data(), end, number).ptr != end || digits.empty()) return std::nullopt;
  const int hours = digits.size() > 2 ? number / 100 : number;
  const int minutes = digits.size() > 2 ? number % 100 : 0;
  return (zone.front() == '-' ? -60.0 : 60.0) * (60 * hours + minutes);
}

/// Days since 1970 of "2026-05-01", "22.05.2026" or "5/22/2026".
std::optional<double> ParseDate(std::string_view text) {
  std::array<int, 3> parts{};
  std::array<std::size_t, 3> digits{};
  if (text.ends_with('.')) text.remove_suffix(1);
  if (text.empty()) return std::nullopt;
  const char mark = text[std::min(text.find_first_not_of("0123456789"), text.size() - 1)];
  bool named = false;  // "01-May-2026"
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, parts[i]);
    digits[i] = static_cast<std::size_t>(read.ptr - text.data());
    if (i == 1 && digits[i] == 0) {
      constexpr std::string_view kMonths = "jan feb mar apr may jun jul aug sep oct nov dec";
      const std::size_t at = kMonths.find(core::PlainLetters(text.substr(0, 3)));
      if (text.size() < 3 || at == std::string_view::npos || at % 4 != 0) return std::nullopt;
      parts[i] = static_cast<int>(at / 4) + 1;
      digits[i] = 3;
      named = true;
    } else if (read.ec != std::errc() || digits[i] > 4) {
      return std::nullopt;
    }
    text.remove_prefix(digits[i]);
    if (i < 2 && (text.empty() || text.front() != mark)) return std::nullopt;
    if (i < 2) text.remove_prefix(1);
  }
  if (!text.empty() || std::string_view("-./").find(mark) == std::string_view::npos) {
    return std::nullopt;
  }
  const bool year_first = digits[0] == 4;
  if (!year_first && digits[2] != 4 && digits[2] != 2) return std::nullopt;
  const bool month_first = !year_first && !named && mark == '/' && parts[0] <= 12;
  constexpr int kCentury = 2000;
  const int year = year_first ? parts[0] : parts[2] + (digits[2] == 2 ? kCentury : 0);
  const int month = month_first ? parts[0] : parts[1];
  const int day = year_first ? parts[2] : month_first ? parts[1] : parts[0];
  if (month < 1 || day < 1) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
}

}  // namespace

std::optional<double> ParseClock(char separator, std::string_view cell) {
  cell = Trim(cell.substr(0, std::min(cell.find(" ->"), cell.find("->"))));
  double extra_s = 0.0;
  if (const std::size_t at = cell.find(" days "); at != std::string_view::npos) {  // of pandas
    const auto days = ParseCell(separator, cell.substr(0, at));
    if (!days) return std::nullopt;
    extra_s = kDay_s * *days;
    cell = Trim(cell.substr(at + 6));
  }
  if (const std::size_t at = cell.find_first_of("T ");
      at >= 8 && at <= 11 && cell.substr(0, at).find(':') == std::string_view::npos) {
    const std::optional<double> date = ParseDate(cell.substr(0, at));
    if (!date) return std::nullopt;
    extra_s = kDay_s * *date;
    cell.remove_prefix(at + 1);
  }
  if (cell.ends_with(" UTC")) cell.remove_suffix(4);
  if (cell.ends_with('Z')) cell.remove_suffix(1);
  const bool afternoon = cell.ends_with(" PM") || cell.ends_with(" pm");
  const bool morning = cell.ends_with(" AM") || cell.ends_with(" am");
  if (afternoon || morning) cell.remove_suffix(3);
  if (const std::size_t zone = cell.find_first_of("+-", 1); zone < cell.size()) {
    const std::optional<double> ahead_s = ZoneOf(cell.substr(zone));
    if (!ahead_s) return std::nullopt;
    extra_s -= *ahead_s;
    cell = Trim(cell.substr(0, zone));
  }
  if (cell.empty()) return std::nullopt;
  const std::size_t first = cell.find(':');
  const std::size_t second = cell.find(':', std::min(first, cell.size() - 1) + 1);
  if (first == std::string_view::npos || second == std::string_view::npos) return std::nullopt;
  auto hours = ParseCell(separator, cell.substr(0, first));
  const auto minutes = ParseCell(separator, cell.substr(first + 1, second - first - 1));
  const auto seconds = ParseCell(separator, cell.substr(second + 1));
  if (!hours || !minutes || !seconds) return std::nullopt;
  const auto fits = [](double value, double most) { return value >= 0.0 && value < most; };
  if (!fits(*hours, 25.0) || !fits(*minutes, 60.0) || !fits(*seconds, 61.0)) return std::nullopt;
  if ((afternoon || morning) && *hours == 12.0) hours = 0.0;
  if (afternoon) hours = *hours + 12.0;
  return extra_s + 3600.0 * *hours + 60.0 * *minutes + *seconds;
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

char FindSeparator(std::string_view header) {
  if (Trim(header).starts_with('|')) return '|';
  for (const char separator : {';', '\t', ','}) {
    bool quoted = false;
    for (const char c : header) {
      if (c == '"') quoted = !quoted;
      if (c == separator && !quoted) return separator;
    }
  }
  const std::string_view line = Trim(header);
  const bool blanks = line.find(' ') != std::string_view::npos;
  const bool table =
      line.find(" | ") != std::string_view::npos ||
      (line.find('|') != line.npos && line.find("||") == line.npos && !line.ends_with('|'));
  return table ? '|' : blanks ? ' ' : ',';
}

}  // namespace faultlab::server
