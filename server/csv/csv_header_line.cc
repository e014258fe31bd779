#include "server/csv/csv_header_line.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "server/csv/csv_header.h"
#include "server/csv/csv_text.h"

namespace faultlab::server {
namespace {

constexpr std::uint32_t kLinesMax = 60;
constexpr std::size_t kLineBytesMax = 64 << 10;
constexpr std::size_t kTimeChannel = 0;

bool BeginsWith(std::string_view text, std::string_view lower_case) {
  return text.size() >= lower_case.size() &&
         std::equal(lower_case.begin(), lower_case.end(), text.begin(), [](char a, char b) {
           return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
         });
}

/// Of "sep=;", which Excel writes and obeys.
std::optional<char> StatedSeparator(std::string_view line) {
  if (!BeginsWith(line, "sep=") || line.size() != 5) return std::nullopt;
  return line.back();
}

enum class Names { kNoTime, kTime, kRecording };

Names WhatItNames(std::string_view line, char separator) {
  std::array<bool, kCsvChannelTable.size()> named{};
  for (bool more = true; more;) {
    const CsvColumn column = ParseColumnName(TakeCell(separator, line, more));
    if (column.channel == nullptr || column.either || !column.unknown_unit.empty()) continue;
    named[static_cast<std::size_t>(column.channel - kCsvChannelTable.data())] = true;
  }
  if (!named[kTimeChannel]) return Names::kNoTime;
  const bool measured = HasMeasurement([&](std::size_t at) { return named[at]; });
  return named[kCommandChannel] && measured ? Names::kRecording : Names::kTime;
}

bool BeginsWithANumber(std::string_view line, char separator) {
  bool more = false;
  const std::string_view cell = TakeCell(separator, line, more);
  return ParseCell(separator, cell).has_value() || ParseClock(separator, cell).has_value();
}

}  // namespace

HeaderLine FindHeaderLine(std::string_view text) {
  HeaderLine found;
  std::optional<char> stated;
  LineCursor lines(text);
  while (lines.number() < kLinesMax) {
    const std::optional<std::string_view> line = lines.Next();
    if (!line || line->size() > kLineBytesMax) break;
    std::string_view content = Trim(*line);
    if (const std::optional<char> separator = StatedSeparator(content)) {
      stated = separator;
      continue;
    }
    const bool comment = content.starts_with('#');
    if (comment) content = Trim(content.substr(1));
    if (content.empty()) continue;
    const std::string_view cells = comment ? content : *line;
    const char separator = stated.value_or(FindSeparator(cells));
    if (!comment && BeginsWithANumber(cells, separator)) break;
    const Names names = WhatItNames(cells, separator);
    if (names == Names::kRecording) {
      found = {lines.number(), separator, true};
    } else if (names == Names::kTime && !comment && found.number == 0) {
      found = {lines.number(), separator, false};
    }
  }
  if (found.number == 0 && stated) found.separator = *stated;
  return found;
}

std::string_view AdviceOnNames(std::string_view header) {
  std::string lower(header);
  std::ranges::transform(lower, lower.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  const bool duty =
      lower.find("pwm") != std::string::npos || lower.find("duty") != std::string::npos;
  return duty ? "; a duty cycle needs the supply: write uc_v = duty x supply" : "";
}

std::string AdviceOnFormat(std::string_view text) {
  struct Format {
    std::string_view begins;  ///< lower case
    std::string_view advice;
  };
  constexpr std::array<Format, 6> kFormats = {
      {{"labview measurement",
        "this is a LabVIEW measurement file: write it as text with one row of names above the "
        "numbers, for example t_s,uc_v,um_v (X_Value is the time)"},
       {"record length",
        "this looks like an oscilloscope's export: delete the columns of its settings, and put the "
        "names of the others above them, for example t_s,uc_v,um_v"},
       {"model,",
        "this looks like an oscilloscope's export: keep the rows of numbers, and put the names of "
        "the columns above them, for example t_s,uc_v,um_v"},
       {"pk", "this is a workbook or an archive, not text: save its sheet as CSV"},
       {"matlab 5.0", "this is a MAT file: write its signals as CSV, for example with writetable"},
       {"{", "this is JSON: write a row of names and then a row for each sample, as CSV"}}};
  const std::string_view first = LineCursor(text.substr(0, kLineBytesMax)).Next().value_or("");
  const std::string_view line = Trim(first);
  for (const Format& format : kFormats) {
    if (BeginsWith(line, format.begins)) return std::string(format.advice);
  }
  const bool quoted = line.size() < first.size() && first.find('"') != std::string_view::npos &&
                      line.find('"') == std::string_view::npos;
  if (quoted && line.find_first_of(",;\t") != std::string_view::npos) {
    return "each line is one cell in quotes: take the quotes at its ends away";
  }
  return {};
}

}  // namespace faultlab::server
