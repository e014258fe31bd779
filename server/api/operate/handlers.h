#pragma once

#include "server/api/api.h"

// What operators look at: the history of rigs, alarms, the queue, the effect of an outage.
namespace faultlab::server {

/// The account of a person as operators see it: {"login", "name"}; null for nobody.
boost::json::value PersonToJson(Api& api, std::int64_t account);

}  // namespace faultlab::server
