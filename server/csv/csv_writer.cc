#include "server/csv/csv_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "server/csv/csv_channels.h"
#include "server/csv/file_io.h"

namespace faultlab::server {
namespace {

void AppendNumber(std::string& out, double value) {
  if (std::isnan(value)) {
    return;  // a lost reading is an empty cell
  }
  std::array<char, 32> text;
  const std::to_chars_result end = std::to_chars(text.data(), text.data() + text.size(), value);
  out.append(text.data(), end.ptr);
}

void AppendComment(std::string& out, std::string comment) {
  std::replace_if(
      comment.begin(), comment.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  out += "# " + comment + '\n';
}

}  // namespace

std::string FormatCsv(std::span<const core::Sample> samples, const CsvWriteOptions& options) {
  std::string out;
  FormatCsv(samples, options, [&out](std::string_view piece) { out += piece; });
  return out;
}

void FormatCsv(std::span<const core::Sample> samples,
               const CsvWriteOptions& options,
               const std::function<void(std::string_view)>& take) {
  std::vector<const CsvChannel*> channels;
  const auto is_measured = [&samples](const CsvChannel& channel) {
    return std::ranges::any_of(
        samples, [&](const core::Sample& sample) { return !std::isnan(sample.*channel.member); });
  };
  for (const CsvChannel& channel : kCsvChannelTable) {
    const bool stands_in =
        HasMeasurement([&](std::size_t at) { return is_measured(kCsvChannelTable[at]); });
    const bool needed =
        channel.required && (&channel != &kCsvChannelTable[kUmChannel] || !stands_in);
    if (needed || is_measured(channel)) channels.push_back(&channel);
  }
  constexpr std::size_t kPieceBytes = 16 << 10;
  std::string out;
  for (const std::string& comment : options.comments) {
    AppendComment(out, comment);
  }
  const auto end_cell = [&](const CsvChannel* channel) {
    out += channel == channels.back() ? '\n' : ',';
  };
  for (const CsvChannel* channel : channels) {
    out += channel->name;
    end_cell(channel);
  }
  for (const core::Sample& sample : samples) {
    for (const CsvChannel* channel : channels) {
      AppendNumber(out, sample.*channel->member);
      end_cell(channel);
    }
    if (out.size() >= kPieceBytes) {
      take(out);
      out.clear();
    }
  }
  take(out);
}

core::Status WriteCsv(const std::string& path,
                      std::span<const core::Sample> samples,
                      const CsvWriteOptions& options) {
  return WriteFile(path, FormatCsv(samples, options));
}

}  // namespace faultlab::server
