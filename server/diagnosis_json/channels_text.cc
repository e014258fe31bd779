#include "server/diagnosis_json/channels_text.h"

#include <string>

namespace faultlab::server {

core::Result<core::Channels> ParseChannels(std::string_view text, const core::Bench& bench) {
  if (text == "all") return core::Channels::kAll;
  if (text != "um") {
    return core::Error{core::ErrorCode::kInvalid,
                       "channels '" + std::string(text) + "': expected um or all",
                       "channels"};
  }
  if (bench.um.exists) return core::Channels::kUmOnly;
  return core::Error{core::ErrorCode::kInvalid,
                     "channels 'um': the bench " + bench.name + " does not measure um; use all",
                     "channels"};
}

}  // namespace faultlab::server
