#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include "server/csv/csv_channels.h"
#include "server/csv/csv_record.h"
#include "server/csv/csv_time_base.h"
#include "server/csv/file_io.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;
using core::Sample;

constexpr std::size_t kShownCellBytes = 24;
constexpr std::size_t kColumnsMax = 64;
constexpr std::size_t kCommentsMax = 1000;
constexpr std::string_view kWanted =
    "t_s, uc_v, um_v (required) and ua_v, ia_a, n_rpm (optional), separated by commas";

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

/// What stands in a message: short, and without bytes that would spoil a terminal.
std::string Shown(std::string_view cell) {
  std::string shown(cell.substr(0, kShownCellBytes));
  std::replace_if(
      shown.begin(),
      shown.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; },
      '?');
  return cell.size() > kShownCellBytes ? shown + ".." : shown;
}

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

class Parser {
 public:
  Parser(std::string_view text, std::string_view name, const CsvLimits& limits)
      : text_(text), name_(name), limits_(limits), lines_(WithoutMark(text)) {}

  Result<CsvRecord> Run() {
    if (text_.size() > limits_.bytes_max) {
      return Error{ErrorCode::kTooLarge,
                   std::string(name_) + ": more than " + std::to_string(limits_.bytes_max) +
                       " bytes; split the recording",
                   ""};
    }
    if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF")) {
      return Fail("", "the text is UTF-16, expected UTF-8; save the file as CSV UTF-8");
    }
    if (std::optional<Error> error = ReadHeader()) {
      return *error;
    }
    if (std::optional<Error> error = ReadRows()) {
      return *error;
    }
    if (std::optional<Error> error = CheckChannels()) {
      return *error;
    }
    if (std::optional<Error> error = AssignTimeBase(record_, rows_at_, name_)) {
      return *error;
    }
    return std::move(record_);
  }

 private:
  static std::string_view WithoutMark(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) {
      text.remove_prefix(3);
    }
    return text;
  }

  Error Fail(std::string_view column, const std::string& message) const {
    return CsvError(name_, std::max<std::uint32_t>(lines_.number(), 1), column, message);
  }

  /// The next line that is neither blank nor a comment; comments are kept.
  std::optional<std::string_view> NextContent() {
    while (std::optional<std::string_view> line = lines_.Next()) {
      const std::string_view content = Trim(*line);
      if (content.empty()) {
        continue;
      }
      if (content.front() != '#') {
        return line;
      }
      if (record_.comments.size() < kCommentsMax) {
        record_.comments.emplace_back(Trim(content.substr(1)));
      }
    }
    return std::nullopt;
  }

  std::optional<Error> ReadHeader() {
    const std::optional<std::string_view> header = NextContent();
    if (!header) {
      return Fail("", "the file is empty, expected a header line with " + std::string(kWanted));
    }
    std::array<bool, kCsvChannelTable.size()> found{};
    std::string_view rest = *header;
    for (bool more = true; more;) {
      const std::size_t comma = rest.find(',');
      const std::string_view name = Trim(rest.substr(0, comma));
      more = comma != std::string_view::npos;
      rest.remove_prefix(more ? comma + 1 : rest.size());
      if (columns_.size() == kColumnsMax) {
        return Fail("", "more than " + std::to_string(kColumnsMax) + " columns");
      }
      if (std::optional<Error> error = AddColumn(name, found)) {
        return error;
      }
    }
    for (std::size_t i = 0; i < kCsvChannelTable.size(); ++i) {
      if (found[i]) {
        record_.channels.emplace_back(kCsvChannelTable[i].name);
      } else if (kCsvChannelTable[i].required) {
        return MissingColumn(kCsvChannelTable[i].name, *header);
      }
    }
    return std::nullopt;
  }

  std::optional<Error> AddColumn(std::string_view name, auto& found) {
    for (std::size_t i = 0; i < kCsvChannelTable.size(); ++i) {
      if (name != kCsvChannelTable[i].name) {
        continue;
      }
      if (found[i]) {
        return Fail(name, "appears twice in the header, expected once");
      }
      found[i] = true;
      columns_.push_back(&kCsvChannelTable[i]);
      return std::nullopt;
    }
    columns_.push_back(nullptr);
    record_.notes.push_back(std::string(name_) + ": column '" + Shown(name) +
                            "' is not known and was ignored");
    return std::nullopt;
  }

  Error MissingColumn(std::string_view missing, std::string_view header) const {
    const bool other_separator = header.find(',') == std::string_view::npos &&
                                 header.find_first_of(";\t") != std::string_view::npos;
    const std::string hint = other_separator ? "; here they seem separated by ';' or tabs" : "";
    return Fail(
        missing,
        "missing from the header '" + Shown(header) + "', expected " + std::string(kWanted) + hint);
  }

  std::optional<Error> ReadRows() {
    const std::size_t rows_guess = text_.size() / (columns_.size() * 5 + 1);
    record_.samples.reserve(std::min(rows_guess, limits_.rows_max));
    while (const std::optional<std::string_view> line = NextContent()) {
      if (record_.samples.size() == limits_.rows_max) {
        return Error{ErrorCode::kTooLarge,
                     std::string(name_) + ": more than " + std::to_string(limits_.rows_max) +
                         " rows; split the recording",
                     ""};
      }
      Sample sample;
      if (std::optional<Error> error = ReadRow(*line, sample)) {
        return error;
      }
      record_.samples.push_back(sample);
      rows_at_.push_back(lines_.number());
    }
    constexpr std::size_t kRowsMin = 2;  // one step is needed to know the period
    if (record_.samples.size() < kRowsMin) {
      return Fail("",
                  "the file has " + std::to_string(record_.samples.size()) +
                      " data rows, expected at least 2");
    }
    return std::nullopt;
  }

  std::optional<Error> ReadRow(std::string_view rest, Sample& sample) const {
    std::size_t cells = 0;
    for (bool more = true; more; ++cells) {
      const std::size_t comma = rest.find(',');
      const std::string_view cell = rest.substr(0, comma);
      more = comma != std::string_view::npos;
      rest.remove_prefix(more ? comma + 1 : rest.size());
      if (cells >= columns_.size() || columns_[cells] == nullptr) {
        continue;
      }
      if (std::optional<Error> error = ReadCell(*columns_[cells], cell, sample)) {
        return error;
      }
    }
    if (cells != columns_.size()) {
      return Fail("",
                  "found " + std::to_string(cells) + " cells, expected " +
                      std::to_string(columns_.size()) +
                      " as in the header (decimal point, comma only between cells)");
    }
    return std::nullopt;
  }

  std::optional<Error> ReadCell(const CsvChannel& channel,
                                std::string_view cell,
                                Sample& sample) const {
    cell = Trim(cell);
    double value = core::kAbsent;
    if (!cell.empty()) {
      const char* const begin = cell.data() + (cell.front() == '+' ? 1 : 0);
      const char* const end = cell.data() + cell.size();
      const std::from_chars_result read = std::from_chars(begin, end, value);
      if (read.ec != std::errc() || read.ptr != end || std::isinf(value)) {
        return Fail(channel.name, "expected a number, found '" + Shown(cell) + "'");
      }
    }
    if (channel.finite && std::isnan(value)) {
      return Fail(channel.name,
                  "expected a number in every row, found '" + Shown(cell) +
                      "'; only measured channels may miss a reading");
    }
    // One NaN for all: a lost reading must not carry the bits of some other program.
    sample.*channel.member = std::isnan(value) ? core::kAbsent : value;
    return std::nullopt;
  }

  /// Lost readings are noted; a required channel without any number is refused.
  std::optional<Error> CheckChannels() {
    for (const CsvChannel* channel : columns_) {
      if (channel == nullptr || channel->finite) {
        continue;
      }
      std::size_t lost = 0;
      std::uint32_t first_line = 0;
      for (std::size_t row = 0; row < record_.samples.size(); ++row) {
        if (std::isnan(record_.samples[row].*channel->member)) {
          first_line = lost == 0 ? rows_at_[row] : first_line;
          ++lost;
        }
      }
      if (lost == record_.samples.size() && channel->required) {
        return CsvError(
            name_, first_line, channel->name, "no row has a number, expected the measured voltage");
      }
      if (lost > 0) {
        record_.notes.push_back(std::string(name_) + ": column " + std::string(channel->name) +
                                ": " + std::to_string(lost) + " lost readings, the first in line " +
                                std::to_string(first_line));
      }
    }
    return std::nullopt;
  }

  std::string_view text_;
  std::string_view name_;
  CsvLimits limits_;
  LineCursor lines_;
  std::vector<const CsvChannel*> columns_;  // nullptr = ignored
  std::vector<std::uint32_t> rows_at_;      // line of each sample
  CsvRecord record_;
};

}  // namespace

Result<CsvRecord> ParseCsv(std::string_view text, std::string_view name, const CsvLimits& limits) {
  return Parser(text, name, limits).Run();
}

Result<CsvRecord> ReadCsv(const std::string& path, const CsvLimits& limits) {
  Result<std::string> text = ReadFile(path, limits.bytes_max);
  if (!text) {
    return text.error();
  }
  return ParseCsv(text.value(), path == "-" ? "standard input" : path, limits);
}

}  // namespace faultlab::server
