#pragma once

#include <cstdint>
#include <optional>

#include "core/bench/bench.h"
#include "core/control/compensation_check.h"
#include "core/control/speed_controller.h"
#include "core/control/virtual_actuator.h"
#include "core/types/calibration.h"
#include "core/types/verdict.h"

namespace faultlab::core {

enum class ControlKind {
  kNominal,      ///< the controller of the healthy rig, whatever the diagnosis says
  kCompensated,  ///< a virtual actuator stands before the rig from the first sure verdict on
  kRobust,       ///< one controller for all rigs of the bench, no diagnosis
};

struct ToleranceOptions {
  ControlKind kind = ControlKind::kCompensated;
  /// Added to the rig's input, in turn, after an alarm and until the verdict is sure: a constant
  /// speed tells next to nothing.
  double dither_v = 0.1;
};

/// Keeps the speed of a rig, one tick after another:
///   reading, reference --> Tick --> uc;   verdicts of the pipeline --> Heard
/// Every uc is inside the bench's input range and slew rate, and asks for no more than the supply
/// gives. The current that the rig would have, as it is known, stays below the peak that it stands,
/// and a speed that would heat its winding beyond its limit is not followed. Contract: a bench that
/// measures n, a calibration of it.
class TolerantDrive {
 public:
  /// @param input_v  the rig's input now: the control goes on from it
  TolerantDrive(const Bench& bench,
                const Calibration& calibration,
                double period_s,
                const ToleranceOptions& options,
                double input_v);

  /// @param speed_rad_s  newest reading, motor shaft; without one the last is used
  /// @returns uc of the next period, V
  double Tick(double reference_rad_s, double speed_rad_s);

  /// The newest verdict. A fault that is named, with a value whose standard error is below a fifth
  /// of it, is compensated; when the diagnosis is withdrawn, so is the compensation. One that the
  /// speed refutes (CompensationCheck) is given up at once, until another is heard.
  void Heard(const Verdict& verdict);

  bool compensates() const { return actuator_.compensates(); }
  /// The newest diagnosis was refuted.
  bool gave_up() const { return refuted_.has_value() && !compensates(); }
  /// Of the last tick: is the verdict being waited for?
  bool dithers() const { return dithering_; }
  /// The highest speed that the rig, as it is known now, can settle at and stands for ever; rad/s.
  double reachable_rad_s() const;

 private:
  void Believe(const std::optional<Candidate>& fault);
  /// Of the same part, and of about the same value, as the one that was refuted.
  bool Refuted(const Candidate& fault) const;
  double LargestInput() const;
  /// Without the winding growing too hot.
  double SustainedSpeed() const;
  double Limited(double u) const;

  const Bench& bench_;
  RigParameters rig_;
  double period_s_;
  ToleranceOptions options_;
  SpeedModel healthy_;
  SpeedModel known_;         ///< as the diagnosis has it
  RigParameters known_rig_;  ///< the same
  SpeedController controller_;
  VirtualActuator actuator_;
  std::optional<CompensationCheck> check_;
  std::optional<Candidate> believed_;
  std::optional<Candidate> refuted_;
  double noise_rad_s_;
  double speed_rad_s_ = 0.0;
  double last_u_;
  double before_last_u_;
  double given_v_;  ///< the same without the dither
  bool dithering_ = false;
  std::uint32_t ticks_ = 0;
};

}  // namespace faultlab::core
