#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/storage/database.h"

namespace faultlab::server {

/// The waiting jobs of one owner that name the same rig, "" for none, or that compute.
struct WaitingGroup {
  bool computing = false;
  std::string rig;
  std::string owner;
  std::int64_t since_ms = 0;  ///< the oldest was added, or a job of this owner ended
  int running = 0;            ///< jobs of the owner
};

/// One step in the index for each group, however many jobs wait in it.
std::vector<WaitingGroup> WaitingGroups(Transaction& tx);

/// The owner with the fewest running jobs first, then who has waited longest.
void OrderByTurn(Transaction& tx, std::vector<WaitingGroup>& groups);

/// The oldest job of the group. On PostgreSQL nobody else can change it until the transaction ends.
std::optional<std::string> LockOldest(Transaction& tx,
                                      const WaitingGroup& group,
                                      const std::vector<std::string>& left_out);

}  // namespace faultlab::server
