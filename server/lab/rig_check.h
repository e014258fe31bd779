#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/types/calibration.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/contact_check.h"
#include "hardware/rig.h"

namespace faultlab::server::lab {

/// The check between users (rule 7): so long the bench's usual excitation, then the estimate inside
/// its band. 3 s, or as many samples as that are at 100 Hz on a slower bench.
double CheckSeconds(const core::Bench& bench);

/// The estimate of SWA over the newest 200 samples of a check that excite, and the centre of a
/// rig's band.
struct RigBand {
  double b0d = 0.0;   ///< direct term, per V: every relay position of the paper's bench changes it
  double gain = 0.0;  ///< (b0d + b1d) / (1 + a1d)
  double a1d = 0.0;   ///< minus the pole
};
/// What healthy rigs of a class give in a check.
struct RigNorm {
  RigBand centre;
  /// Standard deviations, by friction and noise alone: relative for b0d and gain.
  RigBand spread;
};
/// Of the data sheet, for a rig that was never commissioned: the bench's usual simulator makes the
/// check, several times, with the friction that `bench.norm` expects. Refuses a bench whose usual
/// excitation gives no estimate.
core::Result<RigNorm> NominalNorm(const core::Bench& bench, double delta_s);

/// One step of a check, in the order in which it was made. A check ends at its first failed step,
/// but for the relays and the estimate, of which every line is looked at.
struct CheckStep {
  struct Figure {
    double measured = 0.0;
    double low = 0.0;  ///< allowed
    double high = 0.0;
    std::string unit;  ///< "1/V", "" for a1d, "V" or "A" of a contact
  };
  /// "interlock", "relay", "record", "b0d", "gain", "a1d", "norm", "contact".
  std::string step{};
  std::string subject{};  ///< of a relay or contact: "R1 = 56, Do1"
  bool passed = false;
  std::optional<Figure> figure{};
  std::string text{};  ///< what is wrong, for the operator
};

struct RigVerdict {
  bool passed = false;
  std::string text{};                 ///< what failed, for the operator
  std::optional<RigBand> measured{};  ///< set when the record gave an estimate
  /// Nothing was checked, because the rig did not accept the lease (another lab holds it, its
  /// messages do not arrive). The check is tried again; the rig's health is unknown.
  bool put_off = false;
  std::vector<CheckStep> steps{};  ///< as far as the check came
};
/// The verdict of a check that ended with an error. What was this server's own silence (kBusy of
/// PlayRun) is put off. If the rig has seen a higher epoch than the
/// lease's, the check fails with the message that an operator must adopt the rig; if the rig cannot
/// accept the lease now, the check is put off.
RigVerdict VerdictOf(const core::Error& error);
/// Of a check of the contacts: a step for each position.
RigVerdict VerdictOf(const hardware::ContactReport& contacts);

/// Whether this record of a check is that of a healthy rig: b0d and gain within 10 % of the band's,
/// a1d within 0.12, or four standard deviations of `norm.spread` where these are more. Too few or
/// invalid samples fail. Pure.
/// @param band  of this rig; nullopt: norm.centre
RigVerdict JudgeCheck(std::span<const core::Sample> samples,
                      const core::Bench& bench,
                      double delta_s,
                      const RigNorm& norm,
                      const std::optional<RigBand>& band = std::nullopt);
/// Whether this may be stored as the band of a rig: within 30 % of the data sheet and 0.2 of its
/// pole (or four standard deviations), so that a bench with a relay stuck in a fault position is
/// never taken as the norm. The message names what is outside.
core::Status CheckBand(const RigBand& measured, const RigNorm& norm);

/// Whether the estimate of a check is that of a rig with this calibration, by simulating the check
/// as NominalNorm does: within 5 % (0.06 of a1d) or four standard deviations. Milliseconds. Pure.
bool IsOfCalibration(const RigBand& measured,
                     const core::Calibration& calibration,
                     const core::Bench& bench,
                     double delta_s);

/// Walks the relays with read-back, plays the excitation, judges; leaves the rig safe. Blocks as
/// long as the rig's pace needs. Contract: `rig` is idle and leased with `epoch`.
/// @param band  of this rig; nullopt: that of the data sheet
RigVerdict CheckRig(hardware::Rig& rig,
                    hardware::Epoch epoch,
                    const std::optional<RigBand>& band = std::nullopt);

}  // namespace faultlab::server::lab
