#include "server/lab/members.h"

#include <soci/soci.h>

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

using soci::into;
using soci::use;

std::vector<Member> Load(Transaction& tx) {
  return SelectRows<Member>(tx, "lab_member ORDER BY id");
}

void Put(Transaction& tx, const Member& member) {
  PutRow(tx, "lab_member", member);
}

WallTime DatabaseTime(Transaction& tx) {
  std::int64_t now_ms = 0;
  tx.sql() << "SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)", into(now_ms);
  return FromMilliseconds(now_ms);
}

void Remove(Transaction& tx, const std::string& id, WallTime now) {
  tx.sql() << "DELETE FROM lab_member WHERE id = :id", use(id, "id");
  (void)InterruptRuns(tx, id, now);
}

}  // namespace members
}  // namespace faultlab::server::lab
