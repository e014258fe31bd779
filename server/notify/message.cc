#include "server/notify/message.h"

#include <date/date.h>

#include <charconv>

namespace faultlab::server::notify {
namespace {

constexpr std::array<std::string_view, kKindCount> kNames = {"your_turn",
                                                             "booking_reminder",
                                                             "booking_changed",
                                                             "rig_quarantined",
                                                             "alarm",
                                                             "run_ended",
                                                             "job_ended",
                                                             "batch_ended"};
constexpr std::string_view kHook = "hook:";

}  // namespace

std::string_view Name(Kind kind) {
  return kNames.at(static_cast<std::size_t>(kind));
}

std::optional<Kind> ParseKind(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames.at(i) == name) return static_cast<Kind>(i);
  }
  return std::nullopt;
}

bool IsFor(Kind kind, bool person) {
  if (kind == Kind::kRigQuarantined || kind == Kind::kAlarm) return !person;
  return person || kind < Kind::kRunEnded;
}

std::string WriteKinds(const std::set<Kind>& kinds) {
  std::string text;
  for (const Kind kind : kinds) text.append(text.empty() ? "" : ",").append(Name(kind));
  return text;
}

std::set<Kind> ReadKinds(std::string_view text) {
  std::set<Kind> kinds;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    if (const auto kind = ParseKind(text.substr(0, end))) kinds.insert(*kind);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return kinds;
}

std::string HookChannel(std::int64_t hook) {
  return std::string(kHook) + std::to_string(hook);
}

std::optional<std::int64_t> HookOf(std::string_view channel) {
  if (!channel.starts_with(kHook)) return std::nullopt;
  channel.remove_prefix(kHook.size());
  std::int64_t id = 0;
  const char* const end = channel.data() + channel.size();
  const auto [stop, error] = std::from_chars(channel.data(), end, id);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return id;
}

std::string Stamp(WallTime time) {
  return date::format("%FT%TZ", time);
}

}  // namespace faultlab::server::notify
