#pragma once

#include <optional>
#include <string_view>

#include "server/api/request.h"
#include "server/clock.h"
#include "server/lab/lab_service.h"
#include "server/net/peer_address.h"

namespace faultlab::server {

/// Where the object of a request lives, when several servers share the database.
enum class LivesAt {
  kAnywhere,        ///< in the database: any server answers
  kRunsMember,      ///< while the run of {id} lives: at the server that records it
  kRunsViewers,     ///< as kRunsMember, and while its viewers are still told of its end
  kRigsMember,      ///< at the server that has the rig of {id}
  kSessionsMember,  ///< at the server that has the rig of session {id}: it fences the rig first
  kBookingsMember,  ///< the same for booking {id}
  kBodysRig,        ///< at the server that has the rig which the body names
  kEveryMember,     ///< a list: each server has its part
};

/// Which of the servers that share a database answers a request: an object lives in the process of
/// one of them as long as it is live, and in the database for ever. Thread-safe, stateless.
class RequestRouting {
 public:
  /// Both must outlive it.
  RequestRouting(lab::LabService& service, const Clock& clock) : service_(service), clock_(clock) {}

  /// Who must be asked instead of this server; nullopt: it answers itself. What is not in order
  /// with the request (no such rig) this server says itself. The caller may use the route here;
  /// that server asks everything again.
  std::optional<AskPeers> AnsweredElsewhere(LivesAt lives_at, const ApiRequest& request) const;

  /// A list of this server's, with the items of the others behind it: see LivesAt::kEveryMember.
  RouteAnswer JoinedWithOthers(HttpResponse own) const;

  /// The server at which this one-time code opens /ws; nullopt: this one, or none.
  std::optional<PeerAddress> MemberOfCode(std::string_view code) const;

 private:
  std::optional<AskPeers> UnlessSelf(const std::optional<lab::Member>& member) const;
  std::optional<AskPeers> AtRunsMember(const RunRecord& run, bool afterglow) const;
  std::optional<AskPeers> AtMemberOfSession(const ApiRequest& request) const;
  std::optional<AskPeers> AtMemberOfBooking(const ApiRequest& request) const;
  std::optional<AskPeers> AtMemberOfBody(const boost::json::object& body) const;

  lab::LabService& service_;
  const Clock& clock_;
};

}  // namespace faultlab::server
