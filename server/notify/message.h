#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "server/wall_time.h"

namespace faultlab::server::notify {

/// What messages tell. Receivers choose among these.
enum class Kind : std::uint8_t {
  kYourTurn,  ///< a rig is held for somebody: an offer of the queue, or a booking that is due
  kBookingReminder,  ///< a booking begins soon
  kBookingChanged,   ///< moved, cancelled by the lab, or its time is free again
  kRigQuarantined,   ///< for operators
  kAlarm,            ///< whatever operators are shown
  kRunEnded,         ///< one's own; these three only for webhooks of a person
  kJobEnded,
  kBatchEnded,  ///< the last job of a batch
};
inline constexpr int kKindCount = 8;
/// "your_turn", "booking_reminder", ..
std::string_view Name(Kind kind);
std::optional<Kind> ParseKind(std::string_view name);
/// Whether a webhook may be told of it that is the lab's, or one person's.
bool IsFor(Kind kind, bool person);

/// In one column: "booking_changed,your_turn".
std::string WriteKinds(const std::set<Kind>& kinds);
std::set<Kind> ReadKinds(std::string_view text);
struct KindsText {
  static std::string Write(const std::set<Kind>& kinds) { return WriteKinds(kinds); }
  static std::set<Kind> Read(std::string_view text) { return ReadKinds(text); }
};

/// Not kinds: nobody chooses them.
inline constexpr std::string_view kTestKind = "test";

/// A row of the outbox.
struct Message {
  std::int64_t id = 0;
  std::string delivery;      ///< the same at every attempt: receivers drop repeats by it
  std::string channel;       ///< see HookChannel; messages of a channel are sent one by one
  std::int64_t account = 0;  ///< whom it is about; 0: nobody
  std::string kind;          ///< Name(Kind)
  std::string about;         ///< a JSON object: codes and values, no sentences
  WallTime created{};
  std::int64_t attempts = 0;  ///< this one included
  std::string member;         ///< which server sends it now, and
  std::string boot;           ///< in which membership
};

/// All mail: one server takes it.
inline constexpr std::string_view kMailChannel = "mail";
/// "hook:3"
std::string HookChannel(std::int64_t hook);
/// nullopt: not of a webhook.
std::optional<std::int64_t> HookOf(std::string_view channel);

/// RFC 3339 in UTC, with milliseconds.
std::string Stamp(WallTime time);

}  // namespace faultlab::server::notify
