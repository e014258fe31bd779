#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "core/methods/method_session.h"

namespace faultlab::server {

/// {"method", "title", "detected_at_s" (null: no alarm), "looks": [{"after_s", "isolation",
///  "identification", "answer": [{"component", "value", "unit"}]}]}; the last look is at the end of
/// the record. A value that the method cannot size is null.
boost::json::object ToJson(const core::MethodRun& run);
/// The same for a terminal.
std::string ToText(const core::MethodRun& run, const std::string& file);

}  // namespace faultlab::server
