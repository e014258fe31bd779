#include "server/lab/members.h"

#include "server/storage/recording_store.h"
#include "server/storage/rows.h"

namespace faultlab::server::lab {

template <typename Visit>
void Fields(Member& member, Visit&& visit) {
  visit("id", member.id);
  visit("boot", member.boot);
  visit("address", member.address);
  visit("lease_until_ms", member.lease_until);
}

namespace members {

std::vector<Member> Load(Transaction& tx) {
  return SelectRows<Member>(tx, "lab_member ORDER BY id");
}

void Put(Transaction& tx, const Member& member) {
  PutRow(tx, "lab_member", member);
}

WallTime DatabaseTime(Transaction& tx) {
  return *SelectValue<WallTime>(
      tx, "SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)");
}

void Remove(Transaction& tx, const std::string& id, WallTime now) {
  DeleteFrom(tx, "lab_member", {{"id", id}});
  (void)InterruptRuns(tx, id, now);
}

}  // namespace members
}  // namespace faultlab::server::lab
