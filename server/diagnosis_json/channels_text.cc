#include "server/diagnosis_json/channels_text.h"

#include <utility>

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
