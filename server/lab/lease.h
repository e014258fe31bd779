#pragma once

#include <algorithm>
#include <cstdint>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

/// The right of one holder to one rig until a given time. Only the scheduler makes it, in the
/// transaction that activates a session or starts a check. The whole lease is passed to the rig
/// pool, the rig and its agent. A rig refuses every request with an epoch below the highest
/// that it knows.
struct Lease {
  RigId rig;
  SessionId session{};      ///< none for a check between users
  std::uint64_t epoch = 0;  ///< of the rig; increases with every lease
  UserId holder{};          ///< none for guests and checks
  WallTime until{};
};

/// The lease of an active session.
inline Lease LeaseOf(const Session& session) {
  return {session.rig, session.id, session.epoch, session.user, session.hard_end};
}

/// The highest epoch of one rig. Every layer between the calendar and the relays enforces it.
class Fence {
 public:
  void Raise(std::uint64_t epoch) { epoch_ = std::max(epoch_, epoch); }
  bool Admits(std::uint64_t epoch) const { return epoch >= epoch_; }
  std::uint64_t epoch() const { return epoch_; }

 private:
  std::uint64_t epoch_ = 0;
};

}  // namespace faultlab::server::lab
