#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"

namespace faultlab::hardware {

/// One message as lcm-logger wrote it.
struct LcmEvent {
  std::int64_t number = 0;
  std::int64_t timestamp_us = 0;
  std::string channel;
  std::vector<std::uint8_t> data;
};

/// Appends the event as lcm-logger writes it. Contract: the channel has 1 to 999 bytes.
void AppendLcmEvent(const LcmEvent& event, std::string& out);

/// Reads the events of an LCM log, with bounded lengths: liblcm's reader allocates what the file
/// says.
///   sync word EDA1DA01, number 8, time 8, channel length 4, data length 4, channel, data
class LcmEventFile {
 public:
  /// `in` outlives this.
  explicit LcmEventFile(std::istream& in) : in_(in) {}

  /// The next event; nothing at the end, which may come inside an event (the logger was killed).
  /// kInvalid for a channel that is not 1 to 999 bytes long or data of more than 16 MiB.
  core::Result<std::optional<LcmEvent>> Next();

 private:
  bool FindSync();

  std::istream& in_;
};

}  // namespace faultlab::hardware
