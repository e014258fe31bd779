#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/types/result.h"
#include "hardware/rig.h"

namespace faultlab::server {

inline constexpr std::size_t kClientMessageBytesMax = 4096;
inline constexpr std::size_t kClientIdBytesMax = 64;

enum class ViewerAction { kSet, kNominal, kStop };

/// {"type":"command","epoch":3,"id":"7","action":"set","component":"R1","value":100}
struct CommandMessage {
  hardware::Epoch epoch{};
  std::string id;  ///< chosen by the client (text or number), returned unchanged in the ack
  bool id_is_number = false;
  ViewerAction action = ViewerAction::kNominal;
  std::string component;  ///< of kSet: a symbol of the run's bench, unless the client errs
  double value = 0.0;
};

/// {"type":"ping","t":12.5}
struct PingMessage {
  double t = 0.0;
};

/// {"type":"resume","since":1234}: requests everything from sample `since` on.
struct ResumeMessage {
  std::int64_t since = 0;
};

using ClientMessage = std::variant<CommandMessage, PingMessage, ResumeMessage>;

/// Parses one text message of a viewer. Unknown types, unknown fields, missing fields, wrong kinds
/// and non-finite numbers are refused, and the refusal names the field; the input may be any bytes.
core::Result<ClientMessage> ParseClientMessage(std::string_view text);

/// The result of a command that was accepted.
struct Accepted {
  std::optional<double> waits_until_s;  ///< run time at which it acts; nullopt: now
};

/// {"type":"ack","id":..,"ok":..,"waits_until_s":..?,"error":{"code","message"}?}
std::string AckText(const CommandMessage& command, const core::Result<Accepted>& outcome);

}  // namespace faultlab::server
