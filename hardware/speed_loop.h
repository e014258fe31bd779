#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/control/tolerant_drive.h"
#include "core/types/sample.h"
#include "hardware/rig.h"
#include "hardware/rig_limits.h"
#include "hardware/run_plan.h"

namespace faultlab::hardware {

/// The speed control of a rig, a tick after another:
///   plan, newest order, newest sample --> Input --> uc;   what it does --> events
class SpeedLoop {
 public:
  explicit SpeedLoop(RigDescription description, RigLimits limits);

  /// Refuses (kInvalid) a rig without n, and a reference that core::Validate refuses.
  core::Status Check(const RunPlan& plan) const;
  /// Refuses an order without a plan of control, and one of a rig that cannot be.
  core::Status Check(const RigCommand& command) const;

  void Begin(const RunPlan& plan);
  void Accept(std::span<const RigCommand> commands);
  void Heard(const core::Sample& sample) { newest_ = sample; }
  /// @param planned_v  uc of this sample where the loop does not act
  double Input(std::int64_t index, double planned_v, std::vector<RigMessage>& out);

 private:
  void Tell(std::int64_t index, std::vector<RigMessage>& out);

  const RigDescription description_;
  const RigLimits limits_;
  std::optional<SpeedControlPlan> plan_;
  std::optional<core::ReferencePlayer> reference_;
  double period_s_ = 0.0;
  std::optional<core::ControlOrder> order_;
  bool order_is_new_ = false;
  std::optional<core::TolerantDrive> drive_;
  core::Sample newest_;
  std::optional<core::BelievedFault> told_;     ///< the compensation that was told last
  std::optional<core::BelievedFault> refuted_;  ///< the refuted diagnosis that was told last
};

}  // namespace faultlab::hardware
