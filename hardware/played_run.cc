#include "hardware/played_run.h"

#include <chrono>
#include <string>
#include <utility>
#include <variant>

namespace faultlab::hardware {
namespace {

constexpr auto kPatience = std::chrono::milliseconds(200);
constexpr auto kPatienceForEnd = std::chrono::seconds(27);  ///< beyond the plan

core::Error Unavailable(std::string text) {
  return {.code = core::ErrorCode::kUnavailable, .message = std::move(text), .field = {}};
}

}  // namespace

core::Result<std::vector<core::Sample>> PlayRun(Rig& rig,
                                                Epoch epoch,
                                                RunPlan plan,
                                                std::string_view what) {
  using SteadyClock = std::chrono::steady_clock;
  const double plan_s = plan.period_s * static_cast<double>(plan.uc_v.size());
  core::Status status = rig.Arm(std::move(plan), epoch);
  if (status.ok()) status = rig.Start(epoch);
  if (!status.ok()) return status.error();
  const auto give_up =
      SteadyClock::now() + kPatienceForEnd +
      std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(plan_s));
  std::vector<core::Sample> samples;
  std::vector<RigMessage> messages;
  std::string trip;
  std::string stopped;
  ReadStatus read = ReadStatus::kMore;
  while (read == ReadStatus::kMore) {
    if (SteadyClock::now() > give_up) {
      rig.SafeStop(std::string(what) + " took too long");
      return Unavailable("the rig did not finish the plan of " + std::string(what));
    }
    messages.clear();
    read = rig.Read(messages, kPatience);
    for (const RigMessage& message : messages) {
      if (const auto* sample = std::get_if<core::Sample>(&message)) {
        samples.push_back(*sample);
        continue;
      }
      const auto& event = std::get<RigEvent>(message);
      if (event.kind == RigEventKind::kTrip) trip = event.text;
      if (event.kind == RigEventKind::kStopped) stopped = event.text;
    }
  }
  rig.SafeStop(std::string(what) + " has ended");
  if (!trip.empty()) return Unavailable("an interlock tripped: " + trip);
  if (stopped.starts_with("watchdog")) {
    return core::Error{
        .code = core::ErrorCode::kBusy, .message = "the rig stopped: " + stopped, .field = {}};
  }
  if (!stopped.empty()) return Unavailable("the rig stopped: " + stopped);
  return samples;
}

}  // namespace faultlab::hardware
