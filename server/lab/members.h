#pragma once

#include <string>
#include <vector>

#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// A running server of this database. It holds its place by a lease of its own, which it renews
/// with its turns; when the lease ends, the others take its rigs offline and end its runs.
struct Member {
  std::string id;       ///< server_id of its settings
  std::string boot;     ///< random, new with each start: a second server of the same id is another
  std::string address;  ///< "host:port" at which it serves
  WallTime lease_until{};
};

/// Rows of the members. Every function takes part in the caller's transaction, behind
/// lab_store::LockVersion, and throws what the database throws.
namespace members {

std::vector<Member> Load(Transaction& tx);
void Put(Transaction& tx, const Member& member);
/// The time of the database's machine: what the clocks of the members are held against. PostgreSQL.
WallTime DatabaseTime(Transaction& tx);
/// Its runs are interrupted: nothing is recorded into them any more.
void Remove(Transaction& tx, const std::string& id, WallTime now);

}  // namespace members
}  // namespace faultlab::server::lab
