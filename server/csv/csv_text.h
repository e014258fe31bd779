#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server {

/// Lines, cells and numbers of a text, independent of columns.

/// Returns lines with their numbers.
class LineCursor {
 public:
  explicit LineCursor(std::string_view text) : rest_(text) {}

  std::optional<std::string_view> Next() {
    if (rest_.empty()) {
      return std::nullopt;
    }
    const std::size_t end = EndOfLine();
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    return line;
  }
  /// Of the line in the file; one that ends within a cell in quotes counts with the next as one.
  std::uint32_t number() const { return number_; }
  bool at_end() const { return rest_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

 private:
  /// A cell in quotes may hold line breaks (RFC 4180). One quote alone, as of inches, does not
  /// begin a cell that takes the rest of the file.
  std::size_t EndOfLine() const;

  std::string_view rest_;
  std::uint32_t number_ = 0;
};

/// The cell without surrounding blanks, then without quotes.
std::string_view Trim(std::string_view cell);

/// Whether the text begins so, in letters of any size.
bool BeginsWith(std::string_view text, std::string_view lower_case);

/// The cell for a message: short, and without bytes that would disturb a terminal.
std::string Shown(std::string_view cell);

/// Removes the text up to the next separator, and the separator, from `rest`; `more` is false after
/// the last cell. The separator ' ' stands for any number of blanks. In quotes a separator belongs
/// to the cell (RFC 4180).
std::string_view TakeCell(char separator, std::string_view& rest, bool& more);

/// A whole cell as a number: finite or NaN, with a decimal comma if the separator is not a comma.
/// Nothing for a text with thousands separators.
std::optional<double> ParseCell(char separator, std::string_view cell);

/// A reading that was lost, as programs write it: an empty cell, "NA", "null", "-" ..
bool IsAbsent(std::string_view cell);

/// Seconds of a time of day, "09:05:00.25", or since 1970 of a date with one,
/// "2026-05-01T09:05:00.25Z", "22.05.2026 14:05:00", "5/22/2026 14:05:00" (the zone is not looked
/// at). An arrow behind it, as of a serial monitor, is left out.
std::optional<double> ParseClock(char separator, std::string_view cell);

/// The separator of the cells: '|' of a line that begins with it, ';', a tab or ',' if the line
/// contains one outside of quotes, '|' of other tables for people, blanks (' ') between its words,
/// otherwise ','.
char FindSeparator(std::string_view header);

}  // namespace faultlab::server
