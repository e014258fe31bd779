#pragma once

#include <cmath>

#include "core/diagnosis/diagnosis_options.h"
#include "core/types/verdict.h"
#include "tests/paper_rig.h"

namespace faultlab::core {

inline DiagnosisOptions FreeValues(Channels channels) {
  DiagnosisOptions options = paper::Options();
  options.channels = channels;
  options.values = ValuePrior::kNone;
  return options;
}

inline bool Names(const Verdict& verdict, Component component) {
  for (Component named : verdict.group) {
    if (named == component) return true;
  }
  return false;
}

inline double ValueOf(const Verdict& verdict, Component component) {
  for (const Candidate& candidate : verdict.candidates) {
    if (candidate.component == component) return candidate.value;
  }
  return std::nan("");
}

}  // namespace faultlab::core
