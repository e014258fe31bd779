#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "core/types/utf8.h"
#include "server/csv/csv_channels.h"
#include "server/csv/csv_columns.h"
#include "server/csv/csv_decimal_marks.h"
#include "server/csv/csv_format.h"
#include "server/csv/csv_header_line.h"
#include "server/csv/csv_record.h"
#include "server/csv/csv_text.h"
#include "server/csv/csv_time_base.h"
#include "server/csv/csv_two_times.h"
#include "server/csv/file_io.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;
using core::Sample;

constexpr std::size_t kCommentsMax = 1000;
constexpr std::size_t kCommentBytesMax = 256 << 10;  // a bench's description is one
constexpr std::size_t kHeaderBytesMax = 64 << 10;
class Parser {
 public:
  Parser(std::string_view text, std::string_view name, const CsvLimits& limits)
      : text_(text), name_(name), limits_(limits), lines_(text) {}

  Result<CsvRecord> Run() {
    if (std::optional<Error> error = ReadHeader()) {
      return *error;
    }
    if (std::optional<Error> error = ReadRows()) {
      return *error;
    }
    if (const std::string twice = marks_.SayTwoMarks(); !twice.empty()) {
      return Fail("", "csv_not_a_number", twice);
    }
    if (by_clock_) CountFromFirstRow(record_.samples);
    if (const std::string note = LeaveOutBeforeRestart(record_.samples, rows_at_); !note.empty()) {
      record_.notes.push_back(std::string(name_) + ": " + note);
      if (by_clock_) CountFromFirstRow(record_.samples);
    }
    if (by_clock_) {
      record_.notes.push_back(std::string(name_) +
                              ": the time of day was read as seconds from the first row on");
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
  Error Fail(std::string_view column, std::string reason, const std::string& message) const {
    return CsvError(
        name_, std::max<std::uint32_t>(lines_.number(), 1), column, std::move(reason), message);
  }

  /// The next line that is neither blank nor a comment; comments are kept.
  std::optional<std::string_view> NextContent() {
    while (std::optional<std::string_view> line = lines_.Next()) {
      const std::string_view content = Trim(*line);
      if (content.empty()) {
        continue;
      }
      if (content.front() != '#' && !content.starts_with("% ")) {
        return line;
      }
      KeepComment(content);
    }
    return std::nullopt;
  }

  void KeepComment(std::string_view content) {
    if (record_.comments.size() < kCommentsMax && content.size() <= kCommentBytesMax) {
      record_.comments.emplace_back(Trim(content.substr(1)));
    }
  }

  /// The line of names, wherever it stands; what stands above it is left out, and said.
  std::optional<std::string_view> TakeHeader() {
    const HeaderLine header = FindHeaderLine(text_);
    separator_ = header.separator;
    names_a_recording_ = header.whole;
    if (header.number == 0) {
      const std::optional<std::string_view> first = NextContent();
      if (first) separator_ = FindSeparator(*first);
      return first;
    }
    std::uint32_t above = 0;
    while (std::optional<std::string_view> line = lines_.Next()) {
      const std::string_view content = Trim(*line);
      const bool comment = content.starts_with('#') || content.starts_with("% ");
      if (lines_.number() == header.number) {
        if (above > 0) {
          record_.notes.push_back(std::string(name_) + ": " + std::to_string(above) +
                                  (above == 1 ? " line" : " lines") +
                                  " above the names of the columns left out");
        }
        return comment ? Trim(content.substr(1)) : *line;
      }
      if (comment) KeepComment(content);
      if (!comment && !content.empty() && !content.starts_with("sep=")) ++above;
    }
    return std::nullopt;
  }

  std::optional<Error> ReadHeader() {
    const std::optional<std::string_view> header = TakeHeader();
    if (!header) {
      return Fail("",
                  "csv_empty",
                  "the file is empty, expected a header line with " + std::string(kColumnsWanted));
    }
    const NamesLine names{*header,
                          separator_,
                          name_,
                          std::max<std::uint32_t>(lines_.number(), 1),
                          AdviceWithoutTime()};
    const std::string advice = AdviceOnFormat(text_);
    if (!advice.empty() && !names_a_recording_) return Fail("", "csv_other_format", advice);
    if (header->size() > kHeaderBytesMax) return NoHeader(names);
    TRY(auto columns, ReadColumns(names));
    columns_ = std::move(columns.cells);
    record_.channels = std::move(columns.channels);
    record_.questions = std::move(columns.questions);
    std::move(columns.notes.begin(), columns.notes.end(), std::back_inserter(record_.notes));
    if (std::optional<std::string> note = TellTwoTimes(lines_, separator_, columns_)) {
      record_.notes.push_back(std::string(name_) + ": " + *note);
    }
    return std::nullopt;
  }

  std::optional<Error> ReadRows() {
    const std::size_t rows_guess = text_.size() / (columns_.size() * 5 + 1);
    record_.samples.reserve(std::min(rows_guess, limits_.rows_max));
    while (const std::optional<std::string_view> line = NextContent()) {
      if (record_.samples.size() == limits_.rows_max) {
        return Error{ErrorCode::kTooLarge,
                     std::string(name_) + ": more than " + std::to_string(limits_.rows_max) +
                         " rows; split the recording",
                     "",
                     "file_rows_full",
                     {{"most", std::to_string(limits_.rows_max)}}};
      }
      if (rows_at_.empty() && !units_taken_) {
        TRY(units_taken_, TakeUnits({*line, separator_, name_, lines_.number(), {}}, columns_));
        if (units_taken_) continue;
      }
      if (IsWithoutContent(*line)) {
        ++rows_without_content_;
        continue;
      }
      Sample sample;
      if (std::optional<Error> error = ReadRow(*line, sample)) {
        const bool cut = lines_.at_end() && CellsIn(*line) < columns_.size();
        if (!cut || record_.samples.size() < 2) return error;
        record_.notes.push_back(Where() + "the last line, '" + Shown(*line) +
                                "', has too few cells, and was left out");
        break;
      }
      record_.samples.push_back(sample);
      rows_at_.push_back(lines_.number());
    }
    if (rows_without_content_ > 0) {
      record_.notes.push_back(std::string(name_) + ": " + std::to_string(rows_without_content_) +
                              (rows_without_content_ == 1 ? " row" : " rows") +
                              " without content left out");
    }
    constexpr std::size_t kRowsMin = 2;  // one step is needed to know the period
    if (record_.samples.size() < kRowsMin) {
      return Fail("",
                  "csv_too_few_rows",
                  "the file has " + std::to_string(record_.samples.size()) +
                      " data rows, expected at least 2");
    }
    return std::nullopt;
  }

  std::string Where() const {
    return std::string(name_) + ":" + std::to_string(lines_.number()) + ": ";
  }

  /// Separators alone, as spreadsheets write them below a table.
  bool IsWithoutContent(std::string_view line) const {
    return separator_ != ' ' && line.find_first_not_of(" \t\r\"") != std::string_view::npos &&
           std::ranges::all_of(line, [this](char c) {
             const bool rule = separator_ == '|' && (c == '-' || c == '+' || c == ':');
             return c == separator_ || c == ' ' || c == '\t' || c == '"' || rule;
           });
  }

  /// What a comment says of the period: "Ts = 0.01 s".
  std::string AdviceWithoutTime() const {
    for (const std::string& comment : record_.comments) {
      const std::string plain = core::PlainLetters(comment);
      for (const std::string_view word :
           {"ts", "dt", "period", "sample time", "fs", "rate", "hz"}) {
        const std::size_t at = plain.find(word);
        const bool begins = at != std::string::npos && (at == 0 || plain[at - 1] == ' ');
        if (begins && plain.find_first_of("0123456789") != std::string::npos) {
          return "; no column is a time: add one, the number of the row x the period ('" +
                 Shown(comment) + "' says it)";
        }
      }
    }
    return "; no column is a time: add one, the number of the row x the period";
  }

  std::size_t CellsIn(std::string_view line) const {
    std::size_t cells = 0;
    for (bool more = true; more; ++cells) TakeCell(separator_, line, more);
    return cells;
  }

  std::optional<Error> ReadRow(std::string_view rest, Sample& sample) {
    std::size_t cells = 0;
    for (bool more = true; more; ++cells) {
      const std::string_view cell = TakeCell(separator_, rest, more);
      if (cells >= columns_.size()) {
        if (cell.empty()) --cells;  // a tail of separators
        continue;
      }
      if (columns_[cells].channel == nullptr) {
        continue;
      }
      if (std::optional<Error> error = ReadCell(columns_[cells], cell, sample)) {
        return error;
      }
    }
    // What is not read may be missing at the end: a comment that few rows have.
    while (cells < columns_.size() && columns_[cells].channel == nullptr) ++cells;
    if (cells != columns_.size()) {
      return Fail("",
                  "csv_cells_wrong",
                  "found " + std::to_string(cells) + " cells, expected " +
                      std::to_string(columns_.size()) + " as in the header" +
                      (separator_ == ',' ? " (decimal point, comma only between cells)" : ""));
    }
    return std::nullopt;
  }

  /// "0.01 sec" of a program that writes for people; in the unit of the column.
  std::optional<double> ReadWithUnit(const CsvColumn& column, std::string_view cell) {
    const std::size_t blank = cell.find(' ');  // "12 1/min", "12V"
    const std::size_t end =
        std::min(blank != std::string_view::npos ? blank : cell.find_first_not_of("+-0123456789.,"),
                 cell.size());
    const std::string_view digits = cell.substr(0, end);
    const std::optional<double> number =
        !digits.empty() && IsAbsent(digits) ? core::kAbsent : ParseCell(separator_, digits);
    const std::optional<double> factor = UnitFactor(column, Trim(cell.substr(end)));
    if (!number || !factor) return std::nullopt;
    if (separator_ != ',') marks_.See(digits);
    return *number * *factor / column.factor;
  }

  std::optional<Error> ReadCell(const CsvColumn& column, std::string_view cell, Sample& sample) {
    const CsvChannel& channel = *column.channel;
    double value = core::kAbsent;
    bool clock = false;
    if (!IsAbsent(cell)) {
      std::optional<double> number = ParseCell(separator_, cell);
      if (!number && &channel == kCsvChannelTable.data()) {
        number = ParseClock(separator_, cell);
        by_clock_ = by_clock_ || number;
        clock = number.has_value();
      }
      if (!number) {
        number = ReadWithUnit(column, cell);
      } else if (!clock && separator_ != ',') {
        marks_.See(cell);
      }
      if (!number) {
        const bool time = &channel == kCsvChannelTable.data();
        return Fail(
            channel.name,
            "csv_not_a_number",
            "expected a number, found '" + Shown(cell) + "'" +
                (time && cell.size() > 5 ? "; write seconds, or hh:mm:ss.fff, with a date as "
                                           "yyyy-mm-dd before it"
                                         : ""));
      }
      value = *number;
    }
    if (channel.finite && std::isnan(value)) {
      if (&channel == &kCsvChannelTable[kCommandChannel] && cell.empty()) {
        return Fail(channel.name,
                    "csv_not_a_number",
                    "expected a number in every row, found '" + Shown(cell) +
                        "'; where the rows of two sources alternate, bring them together: fill the "
                        "command down, one row a period");
      }
      return Fail(channel.name,
                  "csv_not_a_number",
                  "expected a number in every row, found '" + Shown(cell) +
                      "'; only measured channels may miss a reading");
    }
    // The same NaN everywhere: a lost reading must not contain the bits of another program's NaN.
    if (column.factor != 1.0 && !clock) value *= column.factor;
    if (column.adds) value += sample.*channel.member;
    sample.*channel.member = std::isnan(value) ? core::kAbsent : value;
    return std::nullopt;
  }

  bool HasNumber(std::size_t channel) const {
    return std::ranges::any_of(record_.samples, [channel](const core::Sample& sample) {
      return !std::isnan(sample.*kCsvChannelTable[channel].member);
    });
  }

  /// Adds notes about lost readings; refuses a recording whose measurements have no number.
  std::optional<Error> CheckChannels() {
    const bool measured = HasMeasurement([&](std::size_t at) { return HasNumber(at); });
    for (const CsvColumn& column : columns_) {
      const CsvChannel* const channel = column.channel;
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
      const bool measures =
          HasMeasurement([channel](std::size_t at) { return channel == &kCsvChannelTable[at]; });
      if (measures && !measured) {
        return CsvError(name_,
                        first_line,
                        channel->name,
                        "csv_column_without_numbers",
                        "no row has a number, expected what was measured");
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
  char separator_ = ',';
  std::vector<CsvColumn> columns_;
  bool names_a_recording_ = false;
  bool units_taken_ = false;
  bool by_clock_ = false;  ///< the time is a time of day
  std::size_t rows_without_content_ = 0;
  DecimalMarks marks_;
  std::vector<std::uint32_t> rows_at_;  // line of each sample
  CsvRecord record_;
};

}  // namespace

Result<CsvRecord> ParseCsv(std::string_view text, std::string_view name, const CsvLimits& limits) {
  if (text.size() > limits.bytes_max) {
    return Error{ErrorCode::kTooLarge,
                 std::string(name) + ": more than " + std::to_string(limits.bytes_max) +
                     " bytes; split the recording",
                 "",
                 "file_too_large",
                 {{"most", std::to_string(limits.bytes_max)}}};
  }
  TRY(const CsvText readable, ReadableText(text, name));
  core::Result<CsvRecord> read = Parser(readable.text(), name, limits).Run();
  if (!read.ok()) {
    Error error = read.error();
    if (readable.guessed) error.message += "; the file is no UTF-8: save it as CSV UTF-8";
    return error;
  }
  CsvRecord record = std::move(read).value();
  record.notes.insert(record.notes.begin(), readable.notes.begin(), readable.notes.end());
  return record;
}

Result<CsvRecord> ReadCsv(const std::string& path, const CsvLimits& limits) {
  TRY(auto text, ReadFile(path, limits.bytes_max));
  return ParseCsv(text, path == "-" ? "standard input" : path, limits);
}

}  // namespace faultlab::server
