#pragma once

#include <boost/json.hpp>
#include <span>
#include <string_view>

#include "server/storage/recording_store.h"

// What a list of runs says of each: what happened in it, and what was found.
namespace faultlab::server {

/// [{"component","value","at_s"}], of events of the kind relay_confirmed.
boost::json::array ChangesToJson(std::span<const RecordedEvent> changes);

/// The episodes of a diagnosis with the candidates that they name:
/// [{"verdict","detected_at_s","onset_s","ended_at_s","group","candidates","further"?}]. A
/// diagnosis that is not finished gives its verdict, one that found no fault an empty list.
/// @param diagnosis_json  of a recording or of a live run; may be empty
boost::json::array FindingsToJson(std::string_view diagnosis_json);

}  // namespace faultlab::server
