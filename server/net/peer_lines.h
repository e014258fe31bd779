#pragma once

#include <cstddef>
#include <string>

#include "server/net/client_counts.h"

namespace faultlab::server {

/// The requests that wait for each of the other servers, by caller: one caller has at most a part
/// of the places. For use by one thread.
class PeerLines {
 public:
  enum class Room { kFree, kFull, kCallerFull };
  /// A place; its destructor gives it back.
  struct Place {
    ClientCounts::Place of_peer;
    ClientCounts::Place of_caller;
  };

  /// @param waiting_max     places for one peer
  /// @param per_caller_max  places of one caller among them
  PeerLines(std::size_t waiting_max, std::size_t per_caller_max)
      : waiting_max_(waiting_max), per_caller_max_(per_caller_max) {}

  /// @param peer  its address
  Room RoomFor(const std::string& peer, const std::string& caller) const {
    if (of_peer_.Of(peer) >= waiting_max_) return Room::kFull;
    const bool caller_full = of_caller_.Of(Key(peer, caller)) >= per_caller_max_;
    return caller_full ? Room::kCallerFull : Room::kFree;
  }
  Place Take(const std::string& peer, const std::string& caller) {
    return {of_peer_.Take(peer), of_caller_.Take(Key(peer, caller))};
  }

 private:
  static std::string Key(const std::string& peer, const std::string& caller) {
    return peer + ' ' + caller;
  }

  const std::size_t waiting_max_;
  const std::size_t per_caller_max_;
  ClientCounts of_peer_;
  ClientCounts of_caller_;  ///< by peer and caller
};

}  // namespace faultlab::server
