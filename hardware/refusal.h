#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/types/number_text.h"
#include "core/types/result.h"

namespace faultlab::hardware {

/// As it stands in messages: six digits, "0.0015".
inline std::string Number(double value) {
  return core::Format("%.6g", value);
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

/// The rig has seen `newest`, and refuses every lease with a lower epoch.
inline core::Error StaleEpoch(std::int64_t epoch, std::int64_t newest) {
  return {core::ErrorCode::kStale,
          "epoch " + std::to_string(epoch) + " is older than the rig's " + std::to_string(newest) +
              ": the lease has gone to somebody else",
          "epoch"};
}

/// Of a rig that plays a plan and cannot close a loop.
inline core::Error NoSpeedControl(const std::string& rig) {
  return core::Refuse("no_speed_control", "control", {{"rig", rig}});
}

}  // namespace faultlab::hardware
