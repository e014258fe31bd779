// What viewers send to the hub: limits, protocol errors, and the three messages of
// client_message.h.
#include <array>
#include <cstdio>

#include "core/types/utf8.h"
#include "server/net/http.h"
#include "server/stream/hub_loop.h"

namespace faultlab::server {
namespace {

using websocket::CloseCode;
using websocket::Opcode;

constexpr int kRefusalsMax = 20;

std::string ErrorText(std::string_view message) {
  std::string text = "{\"type\":\"error\",\"message\":";
  AppendJsonString(text, message);
  text.push_back('}');
  return text;
}

}  // namespace

void HubLoop::Reject(Viewer& viewer,
                     CloseCode code,
                     std::string_view why,
                     std::string_view reason) {
  ++counters_.protocol_errors;
  DeliverText(viewer, ErrorText(why));
  Close(viewer, code, reason);
}

void HubLoop::OnMessage(Viewer& viewer, const websocket::FrameReader::Message& message) {
  const MonotonicTime now = clock_.Monotonic();
  if (now - viewer.rate_window >= std::chrono::seconds(1)) {
    viewer.rate_window = now;
    viewer.messages_in_window = 0;
  }
  if (++viewer.messages_in_window > options_.client_messages_per_s_max) {
    ++counters_.protocol_errors;
    Close(viewer, CloseCode::kPolicy, "too many messages");
    return;
  }
  switch (message.opcode) {
    case Opcode::kPing:
      Deliver(viewer,
              std::make_shared<const std::string>(
                  websocket::EncodeFrame(Opcode::kPong, message.payload)),
              0);
      return;
    case Opcode::kPong:
      return;
    case Opcode::kClose:
      Close(viewer, CloseCode::kNormal, "");
      return;
    case Opcode::kText:
      OnText(viewer, message.payload);
      return;
    default:
      Reject(viewer,
             CloseCode::kUnsupported,
             "only text messages are understood",
             "only text messages are understood");
  }
}

void HubLoop::OnText(Viewer& viewer, const std::string& text) {
  if (!core::IsUtf8(text)) {
    Reject(viewer, CloseCode::kInvalidText, "the text is not UTF-8", "not UTF-8");
    return;
  }
  auto parsed = ParseClientMessage(text);
  Channel& channel = *channels_[viewer.channel];
  if (!parsed) {
    ++counters_.protocol_errors;
    DeliverText(viewer, ErrorText(parsed.error().message));
    // A wrong field is an error of a program that uses this protocol; anything else is garbage.
    const bool garbage = parsed.error().field.empty();
    if (garbage) Close(viewer, CloseCode::kInvalidText, "not a message of this server");
    if (++viewer.refusals >= kRefusalsMax) Close(viewer, CloseCode::kPolicy, "too many errors");
    return;
  }
  if (const auto* ping = std::get_if<PingMessage>(&parsed.value())) {
    std::array<char, 128> pong;
    const int size = std::snprintf(pong.data(),
                                   pong.size(),
                                   "{\"type\":\"pong\",\"t\":%.17g,\"server_t\":%.6f}",
                                   ping->t,
                                   ServerSeconds(channel));
    DeliverText(viewer, {pong.data(), static_cast<std::size_t>(size)});
  } else if (const auto* resume = std::get_if<ResumeMessage>(&parsed.value())) {
    viewer.catch_up = std::min(resume->since, channel.history.next());
    if (viewer.drained()) CatchUp(viewer);
  } else if (const auto* command = std::get_if<CommandMessage>(&parsed.value())) {
    if (!viewer.can_command) {
      DeliverText(viewer, AckText(*command, core::Refuse("watching_only")));
    } else if (!channel.options.on_command) {
      DeliverText(viewer, AckText(*command, core::Refuse("run_ended")));
    } else {
      channel.options.on_command(ViewerId{viewer.id()}, *command);
    }
  }
}

}  // namespace faultlab::server
