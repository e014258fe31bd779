#pragma once

#include <cstdint>
#include <vector>

#include "server/lab/scheduler.h"
#include "server/storage/database.h"

namespace faultlab::server::lab {

/// One message to a user.
struct LabEvent {
  std::int64_t seq = 0;
  UserId user{};
  WallTime at{};
  std::string topic;
  std::string text;
  SessionId session{};
};

/// The scheduler's state in tables. Every function takes part in the caller's transaction and
/// throws what the database throws.
namespace lab_store {

/// Increases with every stored transition. On PostgreSQL the row stays locked until the transaction
/// ends, so that servers change the lab one after the other.
std::int64_t LockVersion(Transaction& tx);
/// Runs of this server, of the last day, that are stored as running although their rig has had a
/// newer lease since: they are about to end, or their end was not stored.
std::vector<std::string> RunsOfPastLeases(Transaction& tx,
                                          const std::string& server_id,
                                          WallTime now);
/// Loads everything that has not ended.
LabState Load(Transaction& tx);
/// Stores the changes and the next version. Things that have ended stay as history.
void Save(Transaction& tx, const Changes& changes, std::int64_t version);
void AddEvents(Transaction& tx, const std::vector<LabEvent>& events);
/// Events of one user after `since`, oldest first.
std::vector<LabEvent> EventsSince(Transaction& tx, UserId user, std::int64_t since, int limit);
/// The newest sequence number of a user, 0 when there is none.
std::int64_t NewestEvent(Transaction& tx, UserId user);

}  // namespace lab_store
}  // namespace faultlab::server::lab
