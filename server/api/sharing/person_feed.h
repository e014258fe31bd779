#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "server/api/api.h"

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
  ~PersonFeed();
  PersonFeed(const PersonFeed&) = delete;
  PersonFeed& operator=(const PersonFeed&) = delete;

  /// Name of the person's channel, which is open from now on for twelve hours.
  std::string Open(lab::UserId user);

 private:
  struct Listener {
    std::string channel;
    std::string told;       ///< tickets, sessions, bookings as last sent
    std::int64_t next = 0;  ///< newest event already told
    MonotonicTime expires{};
  };

  void Loop();
  void TellAll(const lab::LabState& state);
  /// "tickets":[..],"sessions":[..],"bookings":[..]
  std::string Holdings(const lab::LabState& state, lab::UserId user) const;
  std::int64_t NewestEvent(lab::UserId user) const;

  Api& api_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::map<lab::UserId, Listener> listeners_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server
