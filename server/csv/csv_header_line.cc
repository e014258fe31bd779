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
constexpr int kRowsBeforeMost = 10;
constexpr std::size_t kLineBytesMax = 64 << 10;
constexpr std::size_t kTimeChannel = 0;

/// Of "sep=;", which Excel writes and obeys.
std::optional<char> StatedSeparator(std::string_view line) {
  if (!BeginsWith(line, "sep=") || line.size() != 5) return std::nullopt;
  return line.back();
}

enum class Names { kNoTime, kTime, kRecording };

Names WhatItNames(std::string_view line, char separator) {
  std::array<bool, kCsvChannelTable.size()> named{};
  for (bool more = true; more;) {
    const std::string_view cell = TakeCell(separator, line, more);
    if (ParseClock(separator, cell)) return Names::kNoTime;  // when it was recorded
    const CsvColumn column = ParseColumnName(cell);
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
  int rows = 0;
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
    const bool comment = content.starts_with('#') || content.starts_with("% ");
    if (comment) content = Trim(content.substr(1));
    if (content.empty()) continue;
    const std::string_view cells = comment ? content : *line;
    const char separator = stated.value_or(FindSeparator(cells));
    if (!comment && BeginsWithANumber(cells, separator)) {
      // A serial monitor shows the last rows of the run before.
      if (found.whole || found.number != 0 || ++rows > kRowsBeforeMost) break;
      continue;
    }
    const Names names = WhatItNames(cells, separator);
    if (names == Names::kRecording) {
      found = {lines.number(), separator, true};
    } else if (names == Names::kTime && !comment && found.number == 0 && rows == 0) {
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

}  // namespace faultlab::server
