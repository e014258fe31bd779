#include "server/experiment/fault_set_access.h"

namespace faultlab::server {

core::Result<Ownership> FaultSetAccess::OwnershipOf(const Principal& who, const FaultSet& set) {
  // By the role of today: who makes sets no more has no hidden ones.
  const bool makes_sets = Authorize(who, Operation::kManageFaultSet, Ownership::kOwn).ok();
  if (makes_sets && set.author == who.user_id) return Ownership::kOwn;
  if (set.course_id == 0) return Ownership::kForeign;
  if (makes_sets) {
    TRY(const auto teaches, accounts_.Teaches(who.user_id, set.course_id));
    if (teaches) return Ownership::kOwn;
  }
  TRY(auto attends, accounts_.Attends(who.user_id, set.course_id));
  return attends && set.visible ? Ownership::kCourse : Ownership::kForeign;
}

core::Result<FaultSet> FaultSetAccess::Find(const Principal& who,
                                            std::int64_t id,
                                            Operation operation) {
  TRY(auto set, sets_.Get(id));
  TRY(auto ownership, OwnershipOf(who, set));
  TRY_DONE(Authorize(who, operation, ownership));
  return set;
}

}  // namespace faultlab::server
