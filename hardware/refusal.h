#pragma once

#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "core/types/result.h"

namespace faultlab::hardware {

/// As it stands in messages: six digits, "0.0015".
inline std::string Number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

/// What was asked for is wrong. `field` names the member of the request.
inline core::Error Invalid(std::string message,
                           std::string field,
                           std::string reason,
                           std::vector<core::ErrorParameter> parameters = {}) {
  return {core::ErrorCode::kInvalid,
          std::move(message),
          std::move(field),
          std::move(reason),
          std::move(parameters)};
}

/// Of a rig that plays a plan and cannot close a loop.
inline core::Error NoSpeedControl(const std::string& rig) {
  return Invalid("rig " + rig + " plays a plan: it cannot control its speed",
                 "control",
                 "no_speed_control",
                 {{"rig", rig}});
}

}  // namespace faultlab::hardware
