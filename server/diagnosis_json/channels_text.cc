#include "server/diagnosis_json/channels_text.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

#include "core/types/estimated_channel.h"
#include "server/diagnosis_json/channel_ranges.h"

namespace faultlab::server {

core::Result<core::Channels> ParseChannels(std::string_view text, const core::Bench& bench) {
  if (text == "all") return core::Channels::kAll;
  if (text != "um") {
    return core::Error{core::ErrorCode::kInvalid,
                       "channels '" + std::string(text) + "': expected um or all",
                       "channels",
                       "word_unknown",
                       {{"member", "channels"}, {"words", "um, all"}}};
  }
  const char* why = nullptr;
  if (!bench.um.exists) {
    why = "does not measure um";
  } else if (bench.structure->estimated != core::EstimatedChannel::kUm) {
    why = "has a driver, whose voltage says little of the motor";
  }
  if (why == nullptr) return core::Channels::kUmOnly;
  return core::Error{core::ErrorCode::kInvalid,
                     "channels 'um': the bench " + bench.name + " " + why + "; use all",
                     "channels",
                     "channel_missing",
                     {{"bench", bench.name}}};
}

namespace {

/// "um_v"
std::string ColumnOf(const core::EstimatedChannelInfo& channel) {
  std::string unit(channel.unit);
  for (char& letter : unit) letter = static_cast<char>(std::tolower(letter));
  return std::string(channel.name) + "_" + unit;
}

}  // namespace

core::Result<std::vector<std::string>> NotesOnRecord(std::span<const std::string> columns,
                                                     std::span<const core::Sample> samples,
                                                     const core::Bench& bench,
                                                     std::string_view file) {
  const core::EstimatedChannelInfo& needed = core::InfoOf(bench.structure->estimated);
  const std::string column = ColumnOf(needed);
  const auto has = [&](std::string_view name) {
    return std::ranges::find(columns, name) != columns.end();
  };
  if (!has(column)) {
    std::string message = std::string(file) + ": column " + column + ": missing: the bench " +
                          bench.name + " is diagnosed by " + std::string(needed.name);
    if (has("n_rpm") && !has("um_v") && !has("ia_a")) {
      message +=
          "; with voltage and speed alone, describe a bench of the structure motor-by-speed (the "
          "shipped speed-motor is one): its gain, its time constant and its friction can be told";
    }
    return core::Error{core::ErrorCode::kInvalid,
                       std::move(message),
                       column,
                       "csv_channel_needed",
                       {{"column", column}, {"bench", bench.name}}};
  }
  std::vector<std::string> notes = NotesOnUnused(columns, bench, file);
  TRY(auto beyond, NotesOnRanges(samples, bench, file));
  std::ranges::move(beyond, std::back_inserter(notes));
  return notes;
}

std::vector<std::string> NotesOnUnused(std::span<const std::string> columns,
                                       const core::Bench& bench,
                                       std::string_view file) {
  const std::pair<std::string_view, bool> described[] = {{"um_v", bench.um.exists},
                                                         {"ua_v", bench.ua.exists},
                                                         {"ia_a", bench.ia.exists},
                                                         {"n_rpm", bench.n.exists}};
  std::vector<std::string> notes;
  for (const std::string& column : columns) {
    for (const auto& [name, exists] : described) {
      if (column != name || exists) continue;
      notes.push_back(std::string(file) + ": column " + column + " is not used: the bench " +
                      bench.name + " has no such channel in its description");
    }
  }
  return notes;
}

}  // namespace faultlab::server
