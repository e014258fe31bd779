#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

enum class Contact {
  kRecognised,    ///< um and ia change as this part makes them
  kReadBackOnly,  ///< the part has no effect that can be seen: only the line was read back
  kWrong,         ///< the effect is another one: a wrong wire, a contact that does not close
};
/// "recognised", "read_back_only", "wrong".
std::string_view Name(Contact contact);

/// One relay position of a bench, recognised by its effect. The means are of the second half of its
/// window, where the drive is at its higher level; NaN where a channel is not wired.
struct ContactFinding {
  core::Component component{};
  double value = 0.0;
  std::string line;  ///< "Do16"
  Contact contact = Contact::kReadBackOnly;
  double um_expected_v = core::kAbsent;
  double um_seen_v = core::kAbsent;
  double ia_expected_a = core::kAbsent;
  double ia_seen_a = core::kAbsent;
  std::string text;  ///< of kWrong: what it looks like
};

struct ContactReport {
  std::vector<ContactFinding> positions;  ///< every position but the nominal ones
  std::string nominal;                    ///< what is wrong with the nominal positions; empty: fine
  bool ok = false;
};

/// One run with the supply on, at levels of the bench's usual excitation: nominal windows and
/// windows of one position each in turn, the drive stepping up in the middle of each.
/// @param high_v  uc of the second half of a window; the first half has two thirds of it
RunPlan ContactPlan(const core::Bench& bench, double high_v);
/// The usual one: the end of the bench's usual excitation that is farther from 0.
double ContactDrive(const core::Bench& bench);

/// Compares a run of ContactPlan with what the bench's description makes of it: no second list of
/// expected readings that could differ from the description. A position is recognised when the
/// change that it makes to um and ia is nearest to its own among those of all parts of its board.
/// Pure.
/// @param high_v   of the plan
/// @param delta_s  DAC edge to ADC sample of the rig
ContactReport JudgeContacts(std::span<const core::Sample> samples,
                            const core::Bench& bench,
                            double high_v,
                            double delta_s);

/// Plays and judges; leaves the rig safe. Blocks for the plan's time. Contract: `rig` is idle.
core::Result<ContactReport> CheckContacts(Rig& rig, Epoch epoch);

}  // namespace faultlab::hardware
