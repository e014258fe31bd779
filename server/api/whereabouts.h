#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/api/api.h"

// Which of the servers that share a database answers a request: an object lives in the process of
// one of them as long as it is live, and in the database for ever.
namespace faultlab::server {

/// Who must be asked instead of this server; nullopt: it answers itself. What is not in order with
/// the request (no such run, no such rig, a broken body) this server says itself.
/// The caller may use the route; whether they may see the object is asked where it lives.
std::optional<AskPeers> AnsweredElsewhere(ApiContext& api,
                                          const ApiRoute& route,
                                          const HttpRequest& http);

/// A list of this server's, with the items of the others behind it: see LivesAt::kEveryMember.
RouteAnswer JoinedWithOthers(ApiContext& api, HttpResponse own);

/// The server at which this one-time code opens /ws; nullopt: this one, or none.
std::optional<PeerAddress> MemberOfCode(const ApiContext& api, std::string_view code);

/// kNotFound unless some server of the lab has, or had, this rig.
core::Status RigIsKnown(ApiContext& api, const std::string& rig);

}  // namespace faultlab::server
