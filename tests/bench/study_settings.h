#pragma once

#include <cstdint>

namespace faultlab::study {

struct Settings {
  double hours = 48.0;
  double rig_minutes = 5.0;  ///< of healthy record of one rig
  int trials = 20;
  int robust_trials = 4;
  std::uint64_t seed = 1;
  bool verbose = false;
  const char* output = nullptr;
};

}  // namespace faultlab::study
