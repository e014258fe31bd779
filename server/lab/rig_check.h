#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::server::lab {

/// The check between users (rule 7): 3 s of the paper's PRBS, then the estimate inside its band.
inline constexpr double kCheckSeconds = 3.0;

/// What SWA over the newest 200 samples of a check says of a rig, and the centre of its band.
struct RigBand {
  double b0d = 0.0;  ///< direct term: tells every relay position of R1, R9, R12 and C8 from nominal
  double gain = 0.0;  ///< (b0d + b1d) / (1 + a1d)
  double a1d = 0.0;   ///< minus the pole
};
/// Of the data sheet: for a rig that was never commissioned.
RigBand NominalBand(double period_s, double delta_s);

struct RigVerdict {
  bool passed = false;
  std::string text;                   ///< what failed, for the operator
  std::optional<RigBand> measured{};  ///< when the record gave an estimate
  /// Nothing was checked: the rig did not take the lease (another lab holds it, it is not heard).
  /// To be tried again; it says nothing of the rig's health.
  bool put_off = false;
};
/// Of a check that an error has ended. A lease below what the rig has seen fails the check and says
/// that an operator must adopt the rig; one that the rig cannot take now puts it off.
RigVerdict VerdictOf(const core::Error& error);

/// Is this record of a check that of a healthy rig? b0d and gain within 10 % of the band's, a1d
/// within 0.12. Too few or invalid samples: no. Pure.
RigVerdict JudgeCheck(std::span<const core::Sample> samples,
                      double period_s,
                      double delta_s,
                      const RigBand& band);
/// May this be stored as the band of a rig? Within 30 % of the data sheet and 0.2 of its pole: a
/// bench with a relay stuck in a fault never becomes its own norm. The sentence says what is not.
core::Status CheckBand(const RigBand& measured, const RigBand& nominal);

/// Walks the relays with read-back, plays the PRBS, judges; leaves the rig safe. Blocks as long as
/// the rig's pace needs. Contract: `rig` is idle and leased with `epoch`.
/// @param band  of this rig; nullopt: the data sheet's
RigVerdict CheckRig(hardware::Rig& rig,
                    hardware::Epoch epoch,
                    const std::optional<RigBand>& band = std::nullopt);

}  // namespace faultlab::server::lab
