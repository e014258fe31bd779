#pragma once

#include <string>
#include <vector>

#include "server/diagnosis_json/isolability_question.h"

namespace faultlab::server {

struct IsolabilityCommandOptions {
  IsolabilityQuestion question;     ///< without what the members below say
  std::string excitation = "prbs";  ///< see ReadExcitation
  std::string calibration;          ///< FILE.json of `calibrate`; empty: question.profile
  std::vector<std::string> faults;  ///< "R1=10"; empty: the paper's 18
  bool json = false;
  std::string output;  ///< FILE.png or FILE.json of the figure; empty: none
};

/// Judges a fault set on a rig: what is visible, how small, what looks like what.
int RunIsolability(const IsolabilityCommandOptions& options);

}  // namespace faultlab::server
