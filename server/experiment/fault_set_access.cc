#include "server/experiment/fault_set_access.h"

namespace faultlab::server {

core::Result<Ownership> FaultSetAccess::OwnershipOf(const Principal& who, const FaultSet& set) {
  // By the role of today: who makes sets no more has no hidden ones.
  const bool makes_sets = Allowed(who.role, Operation::kManageFaultSet, Ownership::kOwn);
  if (makes_sets && set.author == who.user_id) return Ownership::kOwn;
  if (set.course_id == 0) return Ownership::kForeign;
  if (makes_sets) {
    const auto teaches = accounts_.Teaches(who.user_id, set.course_id);
    if (!teaches) return teaches.error();
    if (teaches.value()) return Ownership::kOwn;
  }
  auto attends = accounts_.Attends(who.user_id, set.course_id);
  if (!attends) return attends.error();
  return attends.value() && set.visible ? Ownership::kCourse : Ownership::kForeign;
}

core::Result<FaultSet> FaultSetAccess::Find(const Principal& who,
                                            std::int64_t id,
                                            Operation operation) {
  auto set = sets_.Get(id);
  if (!set) return set.error();
  auto ownership = OwnershipOf(who, set.value());
  if (!ownership) return ownership.error();
  const core::Status allowed = Authorize(who, operation, ownership.value());
  if (!allowed.ok()) return allowed.error();
  return set;
}

}  // namespace faultlab::server
