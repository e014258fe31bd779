#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/api/api.h"
#include "server/repeated.h"

namespace faultlab::server {

/// Tells signed-in people at once what changed for them: place in the queue, sessions, bookings,
/// news. One text channel of the stream hub for each person whose page listens; every message is
/// the whole state, so a page that was cut off needs no repair.
///
///   LabService::state() --changed?--> compose for each listener --differs?--> hub --> pages
class PersonFeed {
 public:
  /// Must outlive the feed.
  explicit PersonFeed(Api& api);

  /// Name of the person's channel, which is open from now on for twelve hours.
  std::string Open(lab::UserId user);

 private:
  struct Listener {
    std::string channel;
    std::string told;       ///< tickets, sessions, bookings as last sent
    std::int64_t next = 0;  ///< newest event already told
    MonotonicTime expires{};
  };

  void Look();
  void TellAll(const lab::LabState& state);
  /// "tickets":[..],"sessions":[..],"bookings":[..]
  std::string Holdings(const lab::LabState& state, lab::UserId user) const;
  std::int64_t NewestEvent(lab::UserId user) const;

  Api& api_;

  std::mutex mutex_;
  std::map<lab::UserId, Listener> listeners_;
  std::shared_ptr<const lab::LabState> last_;  ///< that was told
  Repeated looks_;                             ///< last: it uses the others
};

}  // namespace faultlab::server
