#pragma once

#include <boost/json/object.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"

namespace faultlab::server::course {

/// A stretch of the record that shows what the answer says.
struct Evidence {
  double from_s = 0.0;
  double to_s = 0.0;  ///< >= from_s
};
inline constexpr std::size_t kEvidenceMax = 8;

/// What a student says about a trial.
struct Answer {
  std::optional<core::Component> component;  ///< none: the rig was healthy
  double value = 0.0;                        ///< SI unit of the component
  std::optional<double> value_error;         ///< one standard deviation, in that unit
  std::optional<double> at_s;                ///< when the fault began
  double confidence = 1.0;                   ///< that the component is right, [0, 1]
  std::string text;                          ///< why
  std::vector<Evidence> evidence;            ///< at most kEvidenceMax; it gives no points
};

/// {"component": "R1" | null, "value", "unit", "value_error", "at_s", "confidence", "text",
/// "evidence": [{"from_s", "to_s"}]}; a value has the SI unit of its component, and says so. Errors
/// name the field.
core::Result<Answer> ParseAnswer(const boost::json::object& body, const core::Bench& bench);
core::Result<Answer> ParseAnswer(std::string_view document, const core::Bench& bench);
boost::json::object ToJson(const Answer& answer);

}  // namespace faultlab::server::course
