#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <span>

#include "server/api/api.h"

// What a person holds in the lab, as JSON: the bodies of the lists, and of the feed.
namespace faultlab::server {

boost::json::object SessionToJson(Api& api, const lab::Session& session);
boost::json::array TicketsOf(const lab::LabState& state, lab::UserId user, WallTime now);
boost::json::array BookingsOf(const lab::LabState& state, lab::UserId user);
/// Live sessions of the user, and those whose control is offered to the user.
boost::json::array SessionsOf(Api& api, const lab::LabState& state, lab::UserId user);
boost::json::array EventsToJson(Api& api, std::span<const lab::LabEvent> events);

}  // namespace faultlab::server
