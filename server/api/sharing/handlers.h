#pragma once

#include <boost/json/object.hpp>

#include "server/api/api.h"

// Rigs as operators see them, and how people share them: queue, bookings, sessions, calendar.
namespace faultlab::server {

boost::json::object SessionToJson(Api& api, const lab::Session& session);

}  // namespace faultlab::server
