#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hardware/clock.h"
#include "hardware/io_error.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// When a step was due and when it happens, both since the start of the run. `planned` is the
/// machine's own schedule; `actual` holds the overruns too.
struct StepTime {
  Nanoseconds planned{0};
  Nanoseconds actual{0};
  const Clock* clock = nullptr;  ///< of the loop
  Nanoseconds started_at{0};     ///< by that clock

  /// The time since the start of the run at which this is called.
  Nanoseconds Now() const { return clock == nullptr ? actual : clock->Now() - started_at; }
};

/// What a rig does, without thread, lease, queue or pace: those are PacedRig's. The calls never
/// overlap. Every call but MakeSafe may throw; PacedRig then makes the rig safe and ends the run.
class RigMachine {
 public:
  virtual ~RigMachine() = default;

  virtual const RigDescription& description() const = 0;
  /// Refusal names the field of the plan. Cheap, no I/O.
  virtual core::Status Check(const RunPlan& plan) const = 0;
  virtual core::Status Check(const RigCommand& command) const = 0;

  /// Ready for a run that Check has passed.
  virtual void Prepare(const RunPlan& plan) = 0;
  /// Does what is due, appends what there is to say.
  /// @returns when the next step is due, or nothing when the plan was played to its end or trip()
  /// holds.
  virtual std::optional<Nanoseconds> Step(const StepTime& time,
                                          std::span<const RigCommand> commands,
                                          std::vector<RigMessage>& out) = 0;

  /// Drive 0, relays nominal; tries everything even when parts fail.
  /// @returns empty, or what could not be done; trip() names it if it has a name (driver_hang).
  virtual std::string MakeSafe() noexcept = 0;
  virtual SelfTestReport SelfTest() = 0;
  /// The interlock that acted in this run.
  virtual std::optional<Trip> trip() const = 0;
  virtual void ClearTrip() = 0;
};

}  // namespace faultlab::hardware
