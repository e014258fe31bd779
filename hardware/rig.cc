#include "hardware/rig.h"

namespace faultlab::hardware {

std::string_view Name(RigState state) {
  switch (state) {
    case RigState::kOffline:
      return "offline";
    case RigState::kIdle:
      return "idle";
    case RigState::kArmed:
      return "armed";
    case RigState::kRunning:
      return "running";
    case RigState::kStopping:
      return "stopping";
    case RigState::kTripped:
      return "tripped";
  }
  return "?";
}

std::string_view Name(RigKind kind) {
  switch (kind) {
    case RigKind::kBench:
      return "bench";
    case RigKind::kSimulated:
      return "simulated";
    case RigKind::kReplay:
      return "replay";
    case RigKind::kRemote:
      return "remote";
  }
  return "?";
}

std::string_view Name(RigEventKind kind) {
  switch (kind) {
    case RigEventKind::kStarted:
      return "started";
    case RigEventKind::kFaultCommanded:
      return "fault_commanded";
    case RigEventKind::kRelayConfirmed:
      return "relay_confirmed";
    case RigEventKind::kControlBegan:
      return "control_began";
    case RigEventKind::kCompensated:
      return "compensated";
    case RigEventKind::kCompensationEnded:
      return "compensation_ended";
    case RigEventKind::kRefused:
      return "refused";
    case RigEventKind::kTrip:
      return "trip";
    case RigEventKind::kOverrun:
      return "overrun";
    case RigEventKind::kDeltaStrays:
      return "delta_strays";
    case RigEventKind::kGap:
      return "gap";
    case RigEventKind::kFinished:
      return "finished";
    case RigEventKind::kStopped:
      return "stopped";
  }
  return "?";
}

std::optional<RigEventKind> ParseRigEventKind(std::string_view name) {
  for (int i = 0; i <= static_cast<int>(RigEventKind::kStopped); ++i) {
    const auto kind = static_cast<RigEventKind>(i);
    if (Name(kind) == name) return kind;
  }
  return std::nullopt;
}

bool NamesComponent(RigEventKind kind) {
  switch (kind) {
    case RigEventKind::kFaultCommanded:
    case RigEventKind::kRelayConfirmed:
    case RigEventKind::kCompensated:
    case RigEventKind::kCompensationEnded:
    case RigEventKind::kRefused:
      return true;
    default:
      return false;
  }
}

core::Status Rig::Resume(const std::string&) {
  return core::Error{
      core::ErrorCode::kNotFound, "rig " + description().id + " keeps no run", {}, "internal"};
}

}  // namespace faultlab::hardware
