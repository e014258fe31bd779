#include "server/stream/client_message.h"

#include <boost/json.hpp>
#include <cmath>
#include <initializer_list>

#include "core/types/component.h"
#include "server/net/http.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::int64_t kIndexMax = 1'000'000'000;
constexpr std::uint64_t kSafeIntegerMax = 1ULL << 53;

core::Error Refuse(std::string message, std::string field = {}) {
  return {core::ErrorCode::kInvalid, std::move(message), std::move(field), "message_wrong"};
}

core::Error Expected(std::string_view field, std::string_view what) {
  return Refuse("'" + std::string(field) + "' must be " + std::string(what) + ".",
                std::string(field));
}

std::optional<core::Error> RefuseUnknown(const json::object& object,
                                         std::initializer_list<std::string_view> known) {
  for (const auto& member : object) {
    bool found = false;
    for (const std::string_view name : known) found = found || member.key() == name;
    if (!found) {
      const std::string name(member.key().substr(0, kClientIdBytesMax));
      return Refuse("unknown field '" + name + "'.", name);
    }
  }
  return std::nullopt;
}

std::optional<double> Number(const json::object& object, std::string_view name) {
  const json::value* value = object.if_contains(name);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const double number = value->to_number<double>();
  return std::isfinite(number) ? std::optional<double>(number) : std::nullopt;
}

std::optional<std::uint64_t> Count(const json::object& object,
                                   std::string_view name,
                                   std::uint64_t max) {
  const json::value* value = object.if_contains(name);
  if (value == nullptr) return std::nullopt;
  if (value->is_int64() && value->get_int64() >= 0 &&
      static_cast<std::uint64_t>(value->get_int64()) <= max) {
    return static_cast<std::uint64_t>(value->get_int64());
  }
  return std::nullopt;
}

core::Result<ClientMessage> ParseCommand(const json::object& object) {
  if (auto unknown =
          RefuseUnknown(object, {"type", "epoch", "id", "action", "component", "value"})) {
    return *unknown;
  }
  CommandMessage command;
  const auto epoch = Count(object, "epoch", kSafeIntegerMax);
  if (!epoch) return Expected("epoch", "the whole number that hello named");
  command.epoch = hardware::Epoch{*epoch};

  const json::value* id = object.if_contains("id");
  if (id != nullptr && id->is_string() && id->get_string().size() <= kClientIdBytesMax) {
    command.id = std::string(id->get_string());
  } else if (const auto number = Count(object, "id", kSafeIntegerMax)) {
    command.id = std::to_string(*number);
    command.id_is_number = true;
  } else {
    return Expected("id", "a text of at most 64 bytes or a whole number");
  }

  const json::value* action = object.if_contains("action");
  if (action == nullptr || !action->is_string()) {
    return Expected("action", "'set', 'nominal' or 'stop'");
  }
  const json::string& name = action->get_string();
  if (name == "set") {
    command.action = ViewerAction::kSet;
  } else if (name == "nominal") {
    command.action = ViewerAction::kNominal;
  } else if (name == "stop") {
    command.action = ViewerAction::kStop;
  } else {
    return Expected("action", "'set', 'nominal' or 'stop'");
  }
  if (command.action != ViewerAction::kSet) {
    if (object.contains("component")) return Expected("component", "absent with this action");
    if (object.contains("value")) return Expected("value", "absent with this action");
    return ClientMessage(command);
  }

  const json::value* component = object.if_contains("component");
  if (component == nullptr || !component->is_string() || component->get_string().empty() ||
      component->get_string().size() > core::kSymbolBytesMax) {
    return Expected("component", "the symbol of a component, such as \"Ra\"");
  }
  command.component = std::string(component->get_string());
  const auto value = Number(object, "value");
  if (!value || *value <= 0.0) {
    return Expected("value", "a positive number in the SI unit of the component");
  }
  command.value = *value;
  return ClientMessage(command);
}

}  // namespace

core::Result<ClientMessage> ParseClientMessage(std::string_view text) {
  if (text.size() > kClientMessageBytesMax) return Refuse("the message is too long.");
  json::parse_options options;
  options.max_depth = 4;
  boost::system::error_code ec;
  const json::value value = json::parse(text, ec, {}, options);
  if (ec) return Refuse("not JSON: " + ec.message() + ".");
  const json::object* object = value.if_object();
  if (object == nullptr) return Refuse("a message is a JSON object.");
  const json::value* type = object->if_contains("type");
  if (type == nullptr || !type->is_string()) {
    return Expected("type", "'command', 'ping' or 'resume'");
  }
  const json::string& name = type->get_string();
  if (name == "command") return ParseCommand(*object);
  if (name == "ping") {
    if (auto unknown = RefuseUnknown(*object, {"type", "t"})) return *unknown;
    const auto t = Number(*object, "t");
    if (!t) return Expected("t", "a number");
    return ClientMessage(PingMessage{*t});
  }
  if (name == "resume") {
    if (auto unknown = RefuseUnknown(*object, {"type", "since"})) return *unknown;
    const auto since = Count(*object, "since", kIndexMax);
    if (!since) return Expected("since", "a sample index, 0 or more");
    return ClientMessage(ResumeMessage{static_cast<std::int64_t>(*since)});
  }
  return Expected("type", "'command', 'ping' or 'resume'");
}

std::string AckText(const CommandMessage& command, const core::Result<Accepted>& outcome) {
  std::string text = "{\"type\":\"ack\",\"id\":";
  if (command.id_is_number) {
    text.append(command.id);
  } else {
    AppendJsonString(text, command.id);
  }
  if (outcome.ok()) {
    text.append(",\"ok\":true");
    if (const auto& until_s = outcome.value().waits_until_s) {
      text.append(",\"waits_until_s\":").append(json::serialize(json::value(*until_s)));
    }
    return text.append("}");
  }
  text.append(",\"ok\":false,\"error\":{\"code\":");
  AppendJsonString(text, Name(outcome.error().code));
  text.append(",\"message\":");
  AppendJsonString(text, outcome.error().message);
  AppendReason(text, outcome.error());
  return text.append("}}");
}

}  // namespace faultlab::server
