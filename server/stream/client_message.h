#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/types/component.h"
#include "core/types/result.h"
#include "hardware/rig.h"

namespace faultlab::server {

inline constexpr std::size_t kClientMessageBytesMax = 4096;
inline constexpr std::size_t kClientIdBytesMax = 64;

enum class ViewerAction { kSet, kNominal, kStop };

/// {"type":"command","epoch":3,"id":"7","action":"set","component":"R1","value":100}
struct CommandMessage {
  hardware::Epoch epoch{};
  std::string id;  ///< chosen by the client (text or number), echoed in the ack as it came
  bool id_is_number = false;
  ViewerAction action = ViewerAction::kNominal;
  core::Component component = core::Component::kR1;
  double value = 0.0;
};

/// {"type":"ping","t":12.5}
struct PingMessage {
  double t = 0.0;
};

/// {"type":"resume","since":1234}: everything from sample `since` on, please.
struct ResumeMessage {
  std::int64_t since = 0;
};

using ClientMessage = std::variant<CommandMessage, PingMessage, ResumeMessage>;

/// Reads one text message of a viewer. Unknown types, unknown fields, missing fields, wrong kinds
/// and non-finite numbers are refused by name; any bytes may come in.
core::Result<ClientMessage> ParseClientMessage(std::string_view text);

/// What became of a command that was not refused.
struct Accepted {
  std::optional<double> waits_until_s;  ///< run time at which it acts; nullopt: now
};

/// {"type":"ack","id":..,"ok":..,"waits_until_s":..?,"error":{"code","message"}?}
std::string AckText(const CommandMessage& command, const core::Result<Accepted>& outcome);

}  // namespace faultlab::server
