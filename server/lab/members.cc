#include "server/lab/members.h"

#include <soci/soci.h>

#include "server/storage/recording_store.h"

namespace faultlab::server::lab::members {

using soci::into;
using soci::use;

std::vector<Member> Load(Transaction& tx) {
  Member row;
  std::int64_t until_ms = 0;
  soci::statement statement =
      (tx.sql().prepare << "SELECT id, boot, address, lease_until_ms FROM lab_member ORDER BY id",
       into(row.id),
       into(row.boot),
       into(row.address),
       into(until_ms));
  statement.execute(false);
  std::vector<Member> out;
  while (statement.fetch()) {
    row.lease_until = FromMilliseconds(until_ms);
    out.push_back(row);
  }
  return out;
}

void Put(Transaction& tx, const Member& member) {
  const std::int64_t until_ms = ToMilliseconds(member.lease_until);
  tx.sql() << "INSERT INTO lab_member (id, boot, address, lease_until_ms) "
              "VALUES (:id, :boot, :address, :until) ON CONFLICT (id) DO UPDATE SET "
              "boot = excluded.boot, address = excluded.address, "
              "lease_until_ms = excluded.lease_until_ms",
      use(member.id, "id"), use(member.boot, "boot"), use(member.address, "address"),
      use(until_ms, "until");
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

}  // namespace faultlab::server::lab::members
