#pragma once

#include <cstdint>

#include "core/types/result.h"
#include "server/auth/accounts.h"
#include "server/auth/authorization.h"
#include "server/fault_sets/fault_sets.h"

namespace faultlab::server {

/// Who may do what with a fault set. Thread-safe, stateless.
class FaultSetAccess {
 public:
  /// Both must outlive it.
  FaultSetAccess(FaultSets& sets, Accounts& accounts) : sets_(sets), accounts_(accounts) {}

  /// kOwn: its author, or a teacher of its course. kCourse: a student of it, while it is visible.
  core::Result<Ownership> OwnershipOf(const Principal& who, const FaultSet& set);
  /// The set, if `who` may do `operation` on it.
  core::Result<FaultSet> Find(const Principal& who, std::int64_t id, Operation operation);

 private:
  FaultSets& sets_;
  Accounts& accounts_;
};

}  // namespace faultlab::server
