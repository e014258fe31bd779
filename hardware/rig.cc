#include "hardware/rig.h"

#include <array>

namespace faultlab::hardware {

std::string_view Name(RigState state) {
  constexpr std::array<std::string_view, 6> kNames = {
      "offline", "idle", "armed", "running", "stopping", "tripped"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string_view Name(RigKind kind) {
  constexpr std::array<std::string_view, 4> kNames = {"bench", "simulated", "replay", "remote"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string_view Name(RigEventKind kind) {
  constexpr std::array<std::string_view, 13> kNames = {"started",
                                                       "fault_commanded",
                                                       "relay_confirmed",
                                                       "control_began",
                                                       "compensated",
                                                       "compensation_ended",
                                                       "refused",
                                                       "trip",
                                                       "overrun",
                                                       "delta_strays",
                                                       "gap",
                                                       "finished",
                                                       "stopped"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::optional<RigEventKind> ParseRigEventKind(std::string_view name) {
  for (int i = 0; i <= static_cast<int>(RigEventKind::kStopped); ++i) {
    const auto kind = static_cast<RigEventKind>(i);
    if (Name(kind) == name) return kind;
  }
  return std::nullopt;
}

bool NamesComponent(RigEventKind kind) {
  using enum RigEventKind;
  return kind == kFaultCommanded || kind == kRelayConfirmed || kind == kCompensated ||
         kind == kCompensationEnded || kind == kRefused;
}

core::Status Rig::Resume(const std::string&) {
  return core::Error{
      core::ErrorCode::kNotFound, "rig " + description().id + " keeps no run", {}, "internal"};
}

}  // namespace faultlab::hardware
