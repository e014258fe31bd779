#pragma once

#include <string>
#include <vector>

#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// A running server of this database. Its membership is a lease, which it renews at each turn; when
/// the lease ends, the others take its rigs offline and end its runs.
struct Member {
  std::string id;       ///< server_id of its settings
  std::string boot;     ///< random, new with each start
  std::string address;  ///< "host:port" at which it serves
  WallTime lease_until{};
};

/// The rows of the members. Every function takes part in the caller's transaction, after
/// lab_store::LockVersion, and throws what the database throws.
namespace members {

std::vector<Member> Load(Transaction& tx);
void Put(Transaction& tx, const Member& member);
/// The time of the database's machine, with which the members' clocks are compared. PostgreSQL.
WallTime DatabaseTime(Transaction& tx);
/// Removes a member and interrupts its runs: nothing more is recorded into them.
void Remove(Transaction& tx, const std::string& id, WallTime now);

}  // namespace members
}  // namespace faultlab::server::lab
