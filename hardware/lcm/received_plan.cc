#include "hardware/lcm/received_plan.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "hardware/lcm/channels.h"
#include "hardware/lcm/control_codec.h"
#include "hardware/lcm/rig_codec.h"

namespace faultlab::hardware {
namespace {

constexpr std::size_t kMissingMax = 64;

core::Error Refusal(core::ErrorCode code, std::string message, std::string field) {
  return {.code = code, .message = std::move(message), .field = std::move(field)};
}

}  // namespace

core::Status ReceivedPlan::Take(const faultlab_msgs::rig_command_t& piece) {
  if (piece.from < 0 || piece.from >= kPlanSamplesMax || piece.from % kPlanChunkSamples != 0 ||
      piece.uc_v.size() > kPlanChunkSamples) {
    return Refusal(core::ErrorCode::kTooLarge,
                   "not a piece of a plan: at most " + std::to_string(kPlanSamplesMax) + " samples",
                   "uc_v");
  }
  pieces_[piece.from] = piece.uc_v;
  return core::Done{};
}

core::Result<RunPlan> ReceivedPlan::Assemble(const faultlab_msgs::rig_command_t& arm,
                                             const core::Bench& bench,
                                             std::vector<std::int64_t>& missing) const {
  RunPlan plan;
  plan.period_s = arm.period_s;
  plan.seed = static_cast<std::uint64_t>(arm.seed);
  if (arm.to < 0 || arm.to > kPlanSamplesMax) {
    return Refusal(core::ErrorCode::kTooLarge, "the plan is too long", "uc_v");
  }
  for (std::int64_t from = 0; from < arm.to; from += kPlanChunkSamples) {
    const auto piece = pieces_.find(from);
    const auto size =
        static_cast<std::size_t>(std::min<std::int64_t>(kPlanChunkSamples, arm.to - from));
    if (piece == pieces_.end() || piece->second.size() != size) {
      if (missing.size() < kMissingMax) missing.push_back(from);
    } else {
      plan.uc_v.insert(plan.uc_v.end(), piece->second.begin(), piece->second.end());
    }
  }
  if (!missing.empty()) {
    return Refusal(core::ErrorCode::kUnavailable, "parts of the plan were lost on the way", "uc_v");
  }
  for (const faultlab_msgs::fault_t& said : arm.faults) {
    const std::optional<core::Fault> fault = FromMessage(said, bench);
    if (!fault) {
      return Refusal(core::ErrorCode::kInvalid, "no such fault: " + said.component, "faults");
    }
    plan.faults.push_back(*fault);
  }
  for (const faultlab_msgs::rig_reference_t& said : arm.references) {
    plan.control = FromMessage(said);
    if (!plan.control) {
      return Refusal(core::ErrorCode::kInvalid,
                     "no such speed control: " + said.shape + ", " + said.controller,
                     "control");
    }
  }
  return plan;
}

}  // namespace faultlab::hardware
