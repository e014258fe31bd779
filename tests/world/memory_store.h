#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "server/lab/lab_store.h"

namespace faultlab::server::lab::rehearsal {

/// The content of a store in memory: what outlives the servers.
struct MemoryLab {
  LabState state;
  std::int64_t version = 0;
  std::vector<Member> members;
  std::vector<LabEvent> events;
  bool keep_events = true;
};

/// A LabStore in memory. Recordings are not part of it: no run is ever found lost or interrupted.
/// Not thread-safe.
class MemoryStore : public LabStore {
 public:
  /// @param time  the time of the store's machine
  MemoryStore(std::shared_ptr<MemoryLab> lab, bool shared, std::function<WallTime()> time)
      : lab_(std::move(lab)), shared_(shared), time_(std::move(time)) {}

  core::Status Write(const std::function<core::Status(LabTurn&)>& turn) override;
  core::Result<std::vector<LabEvent>> EventsSince(UserId user,
                                                  std::int64_t since,
                                                  int limit) override;
  bool shared() const override { return shared_; }

 private:
  const std::shared_ptr<MemoryLab> lab_;
  const bool shared_;
  const std::function<WallTime()> time_;
};

}  // namespace faultlab::server::lab::rehearsal
