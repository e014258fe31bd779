#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <span>
#include <string>
#include <string_view>

#include "core/bench/bench.h"
#include "core/diagnosis/diagnosis.h"
#include "core/types/component.h"
#include "core/types/estimate.h"
#include "core/types/frame.h"
#include "core/types/result.h"
#include "core/types/verdict.h"

namespace faultlab::server {

/// The only place that converts a diagnosis to JSON, for the command line, HTTP and the live
/// stream. A number that does not exist (NaN, infinity, nothing) is null.

/// ["R1", ..]
boost::json::array ComponentNames(std::span<const core::Component> components);

/// {"gain_rpm_per_v": {"value","sigma"}, "time_constant_s": .., "friction_rpm": ..}
boost::json::object ToJson(const core::SpeedResponse& response);
/// {"verdict","detected_at_s","onset_s","detector","group":[..],"candidates":[{"component","value",
/// "sigma","unit","bound","score","margin","probability"}],"path":[{"question","answer","value","threshold",
/// "leads_to","components":[..],"close"}],"path_outcome"?,"settled","reason",
/// "further"?:[{"detected_at_s","onset_s","detector"}]}; "further" are the alarms of the same fault
/// after the first: the candidates are since the newest.
boost::json::object ToJson(const core::Verdict& verdict);

/// The verdict's members, then "calibration" (null when refused), "calibration_refusal"?,
/// "estimates":{"swa_50":{..}, ..}, "fit_percent":{"nominal":..}, "paper":{..}, "episodes":[..].
/// The program that read the record adds "file", "samples", "period_s" and "channels" in front.
boost::json::object ToJson(const core::Diagnosis& diagnosis, const core::Bench& bench);

/// Reads the output of ToJson(Diagnosis), as stored with a recording. Members that only reports
/// show are skipped: `paper`, the reason of a refusal, the sums of squares. A refusal names the
/// member.
core::Result<core::Diagnosis> ParseDiagnosis(std::string_view text, const core::Bench& bench);

/// {"names":["b0d","b1d","a1d"],"theta","sigma","condition","status","age","nominal"?}
boost::json::object ToJson(core::EstimatorId id, const core::Estimate<3>& estimate);

/// {"nominal","estimate","band":{"b0","b1","a1"},"path","named","single_column","exact",
/// "full_jacobian"}
boost::json::object ToJson(const core::PaperMethods& paper);

/// A calibration for people: a table of the rig's own values with their errors.
std::string ToText(const core::Calibration& calibration, const std::string& name);

/// A diagnosis for people: several complete lines. `name` is the record.
std::string ToText(const core::Diagnosis& diagnosis, const std::string& name);

}  // namespace faultlab::server
