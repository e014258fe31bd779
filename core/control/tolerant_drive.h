#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/bench/limits.h"
#include "core/control/compensation_check.h"
#include "core/control/control_order.h"
#include "core/control/speed_controller.h"
#include "core/control/virtual_actuator.h"

namespace faultlab::core {

/// "nominal", "compensated", "robust".
enum class ControlKind {
  kNominal,      ///< the controller of the healthy rig, whatever the diagnosis says
  kCompensated,  ///< a virtual actuator stands before the rig from the first sure verdict on
  kRobust,       ///< one controller for all rigs of the bench, no diagnosis
};

std::string_view Name(ControlKind kind);
std::optional<ControlKind> ParseControlKind(std::string_view name);

struct ToleranceOptions {
  static constexpr double kDitherMaxV = 1.0;

  ControlKind kind = ControlKind::kCompensated;
  /// Added to the rig's input, in turn, after an alarm and until the verdict is sure: a constant
  /// speed tells next to nothing.
  double dither_v = 0.1;
};

/// Keeps the speed of a rig, one tick after another:
///   reading, reference --> Tick --> uc;   orders of who diagnoses --> Heard
/// Every uc is inside the rig's input range and slew rate, and asks for no more than the supply
/// gives. The current that the rig would have, as it is known, stays below the peak that it stands,
/// and a speed that would heat its winding beyond its limit is not followed. Contract: a rig that
/// measures n, orders that Validate takes.
class TolerantDrive {
 public:
  /// So many readings since an alarm are kept to try a diagnosis on.
  static constexpr std::size_t kTrialTicks = 50;

  /// @param input_v  the rig's input now: the control goes on from it
  TolerantDrive(const BenchLimits& limits,
                const ControlOrder& order,
                double period_s,
                const ToleranceOptions& options,
                double input_v);

  /// @param speed_rad_s  newest reading, motor shaft; without one the last is used
  /// @returns uc of the next period, V
  double Tick(double reference_rad_s, double speed_rad_s);

  /// The newest order. A fault that is believed is compensated; when the diagnosis is withdrawn, so
  /// is the compensation. One that the speed refutes (CompensationCheck) is given up at once, until
  /// another is heard.
  void Heard(const ControlOrder& order);

  bool compensates() const { return actuator_.compensates(); }
  /// What is compensated.
  const std::optional<BelievedFault>& believed() const { return believed_; }
  /// The newest diagnosis was refuted: this one.
  bool gave_up() const { return refuted_.has_value() && !compensates(); }
  const std::optional<BelievedFault>& refuted() const { return refuted_; }
  /// Of the last tick: is the verdict being waited for?
  bool dithers() const { return dithering_; }
  /// The highest speed that the rig, as it is known now, can settle at and stands for ever; rad/s.
  double reachable_rad_s() const { return known().reachable_rad_s(); }

 private:
  void Believe(const std::optional<BelievedFault>& fault);
  /// What was read since the alarm, held against a diagnosis before it acts.
  std::optional<CompensationCheck> Tried(const BelievedFault& fault) const;
  void Remember(double speed_rad_s, double mean_u_v);
  /// Of the same part, and of about the same value, as the one that was refuted.
  bool Refuted(const BelievedFault& fault) const;
  double Limited(double u) const;
  double LagV() const;
  const DriveModel& known() const { return believed_ ? believed_->rig : healthy_; }

  BenchLimits limits_;
  DriveModel healthy_;
  double noise_rad_s_;
  double late_;  ///< share of a period from the edge of uc to the reading
  double period_s_;
  ToleranceOptions options_;
  SpeedController controller_;
  VirtualActuator actuator_;
  std::optional<CompensationCheck> check_;
  std::optional<BelievedFault> believed_;
  std::optional<BelievedFault> refuted_;
  struct Reading {
    double speed_rad_s;
    double mean_u_v;
  };
  std::array<Reading, kTrialTicks> since_alarm_{};  ///< the newest; [read_ % kTrialTicks] is next
  std::size_t read_ = 0;
  bool alarmed_ = false;
  double speed_rad_s_ = 0.0;
  double last_u_;
  double before_last_u_;
  double given_v_;  ///< the same without the dither
  bool dithering_ = false;
  std::uint32_t ticks_ = 0;
};

}  // namespace faultlab::core
