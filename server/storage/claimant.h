#pragma once

#include <string>

#include "server/storage/rows.h"

namespace faultlab::server {

/// A member of the lab in one of its memberships. What it claims is its own for as long as
/// `lab_member` has it with this boot id.
struct Claimant {
  std::string server_id;
  std::string boot;
};

/// On PostgreSQL the membership cannot end, nor pass to a new process, before the transaction ends:
/// whoever ends it sees the claim.
inline bool LockMembership(Transaction& tx, const Claimant& who) {
  std::string query = "SELECT 1 FROM lab_member WHERE id = :id AND boot = :boot";
  if (tx.engine() == Engine::kPostgresql) query += " FOR SHARE";
  return SelectValue<int>(tx, query, {{"id", who.server_id}, {"boot", who.boot}}).has_value();
}

}  // namespace faultlab::server
