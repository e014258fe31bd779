#pragma once

#include <string>
#include <vector>

#include "server/diagnosis_json/isolability_question.h"

namespace faultlab::server {

struct IsolabilityCommandOptions {
  IsolabilityQuestion question;     ///< the members below complete it
  std::string excitation;           ///< see ReadExcitation; empty: the bench's
  std::string bench;                ///< FILE.toml; empty: the paper's
  std::string calibration;          ///< FILE.json of `calibrate`; empty: question.profile
  std::vector<std::string> faults;  ///< "R1=10"; empty: see FaultsOf
  bool json = false;
  std::string output;  ///< FILE.png or FILE.json of the figure; empty: none
};

/// Judges a fault set on a rig: which faults are visible, down to which size, and which can be
/// confused.
int RunIsolability(const IsolabilityCommandOptions& options);

}  // namespace faultlab::server
