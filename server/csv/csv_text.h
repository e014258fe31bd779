#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server {

/// Lines, cells and numbers of a text; knows nothing of columns.

/// Hands out lines with their numbers; knows nothing of columns.
class LineCursor {
 public:
  explicit LineCursor(std::string_view text) : rest_(text) {}

  std::optional<std::string_view> Next() {
    if (rest_.empty()) {
      return std::nullopt;
    }
    const std::size_t end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    return line;
  }
  std::uint32_t number() const { return number_; }

 private:
  std::string_view rest_;
  std::uint32_t number_ = 0;
};

/// Without blanks around it, then without quotes.
std::string_view Trim(std::string_view cell);

/// What stands in a message: short, and without bytes that would spoil a terminal.
std::string Shown(std::string_view cell);

/// The text up to the next separator, which goes with it; `more` is false behind the last cell. The
/// separator ' ' stands for any number of blanks.
std::string_view TakeCell(char separator, std::string_view& rest, bool& more);

/// A whole cell as a number: finite or NaN, a decimal comma where the separator leaves it free.
/// Nothing for marks of thousands.
std::optional<double> ParseCell(char separator, std::string_view cell);

}  // namespace faultlab::server
