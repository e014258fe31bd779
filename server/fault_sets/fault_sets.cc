#include "server/fault_sets/fault_sets.h"

#include <soci/soci.h>

#include <optional>

#include "server/storage/not_yours.h"
#include "server/storage/turns.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

constexpr const char* kColumns =
    "id, course_id, account_id, name, bench, version, visible, faults, pool, used, replaces, "
    "created_ms";

struct Row {
  FaultSet set;
  std::int64_t visible = 0;
  std::int64_t used = 0;
  std::int64_t created_ms = 0;
  FaultSet ToSet() const {
    FaultSet out = set;
    out.visible = visible != 0;
    out.used = used != 0;
    out.created_at = FromMilliseconds(created_ms);
    return out;
  }
};

Error Full() {
  const std::string most = std::to_string(FaultSets::kOfAuthorMax);
  return {ErrorCode::kConflict,
          "You have " + most + " fault sets, as many as one person may have; delete some first.",
          "",
          "fault_sets_full",
          {{"most", most}}};
}
Error Changed() {
  return {
      ErrorCode::kStale, "the fault set has changed; look at it again", "", "fault_set_changed"};
}

template <typename Each>
void ForEachRow(Transaction& tx, const std::string& condition, const Each& each) {
  Row row;
  soci::statement statement =
      (tx.sql().prepare << std::string("SELECT ") + kColumns + " FROM fault_set WHERE " + condition,
       into(row.set.id),
       into(row.set.course_id),
       into(row.set.author),
       into(row.set.name),
       into(row.set.bench),
       into(row.set.version),
       into(row.visible),
       into(row.set.faults_json),
       into(row.set.pool_json),
       into(row.used),
       into(row.set.replaces),
       into(row.created_ms));
  statement.execute(false);
  while (statement.fetch()) each(row.ToSet());
}

std::optional<FaultSet> Find(Transaction& tx, std::int64_t id) {
  std::optional<FaultSet> found;
  ForEachRow(
      tx, "deleted = 0 AND id = " + std::to_string(id), [&](const FaultSet& set) { found = set; });
  return found;
}

FaultSet Insert(Transaction& tx, const FaultSet& set) {
  const std::int64_t visible = set.visible ? 1 : 0;
  const std::int64_t created_ms = ToMilliseconds(set.created_at);
  FaultSet out = set;
  out.used = false;
  // The newest id may be another server's set.
  tx.sql()
      << "INSERT INTO fault_set (course_id, account_id, name, bench, version, visible, faults, "
         "pool, used, deleted, replaces, created_ms) VALUES (:course, :author, :name, :bench, "
         ":version, :visible, "
         ":faults, :pool, 0, 0, :replaces, :created) RETURNING id",
      into(out.id), use(set.course_id, "course"), use(set.author, "author"), use(set.name, "name"),
      use(set.bench, "bench"), use(set.version, "version"), use(visible, "visible"),
      use(set.faults_json, "faults"), use(set.pool_json, "pool"), use(set.replaces, "replaces"),
      use(created_ms, "created");
  return out;
}

/// A used set is kept because its runs refer to it, but only the newest kOfAuthorMax of an author.
void Retire(Transaction& tx, const FaultSet& set) {
  const std::int64_t kept = FaultSets::kOfAuthorMax;
  tx.sql() << "UPDATE fault_set SET deleted = 1 WHERE id = :id", use(set.id, "id");
  tx.sql() << "DELETE FROM fault_set WHERE account_id = :author AND deleted = 1 AND id <= "
              "(SELECT id FROM fault_set WHERE account_id = :same AND deleted = 1 "
              "ORDER BY id DESC LIMIT 1 OFFSET :kept)",
      use(set.author, "author"), use(set.author, "same"), use(kept, "kept");
}

}  // namespace

core::Result<FaultSet> FaultSets::Create(FaultSet set) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<FaultSet> {
    TakeTurn(tx, "fault sets of " + std::to_string(set.author));
    std::int64_t kept = 0;
    tx.sql() << "SELECT COUNT(*) FROM fault_set WHERE account_id = :author AND deleted = 0",
        into(kept), use(set.author, "author");
    if (kept >= kOfAuthorMax) return Full();
    return Insert(tx, set);
  });
}

core::Result<FaultSet> FaultSets::Change(const FaultSet& set, std::int64_t version) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<FaultSet> {
    TakeTurn(tx, "fault set " + std::to_string(set.id));
    const auto before = Find(tx, set.id);
    if (!before) return NotYours();
    if (before->version != version) return Changed();
    FaultSet next = set;
    next.version = version + 1;
    if (before->used) {
      next.replaces = before->id;
      Retire(tx, *before);
      return Insert(tx, next);
    }
    const std::int64_t visible = set.visible ? 1 : 0;
    tx.sql() << "UPDATE fault_set SET name = :name, bench = :bench, visible = :visible, faults = "
                ":faults, "
                "pool = :pool, version = :version WHERE id = :id",
        use(next.name, "name"), use(next.bench, "bench"), use(visible, "visible"),
        use(next.faults_json, "faults"), use(next.pool_json, "pool"), use(next.version, "version"),
        use(next.id, "id");
    return *Find(tx, set.id);
  });
}

core::Status FaultSets::Delete(std::int64_t id, std::int64_t version) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TakeTurn(tx, "fault set " + std::to_string(id));
    const auto before = Find(tx, id);
    if (!before) return NotYours();
    if (before->version != version) return Changed();
    if (before->used) {
      Retire(tx, *before);
    } else {
      tx.sql() << "DELETE FROM fault_set WHERE id = :id", use(id, "id");
    }
    return Done{};
  });
}

core::Result<FaultSet> FaultSets::Get(std::int64_t id) {
  return database_.Read([&](Transaction& tx) -> core::Result<FaultSet> {
    const auto found = Find(tx, id);
    if (!found) return NotYours();
    return *found;
  });
}

core::Result<std::vector<FaultSet>> FaultSets::List(std::optional<Reader> reader,
                                                    std::int64_t after,
                                                    int limit) {
  using Sets = std::vector<FaultSet>;
  std::string condition = "deleted = 0 AND id > " + std::to_string(after);
  if (reader) {
    const std::string me = "account_id = " + std::to_string(reader->account);
    const std::string courses = "course_id IN (SELECT course_id FROM enrolment WHERE " + me;
    condition += " AND ((visible = 1 AND " + courses + "))";
    if (reader->makes_sets) condition += " OR " + me + " OR " + courses + " AND teaches = 1)";
    condition += ")";
  }
  condition += " ORDER BY id LIMIT " + std::to_string(limit);
  return database_.Read([&](Transaction& tx) -> core::Result<Sets> {
    Sets out;
    ForEachRow(tx, condition, [&](const FaultSet& set) { out.push_back(set); });
    return out;
  });
}

core::Status FaultSets::MarkUsed(std::int64_t id) {
  // Most sets are marked already; then no write is needed, which would make others wait.
  const auto set = Get(id);
  if (!set.ok() && set.error().code != ErrorCode::kNotFound) return set.error();
  if (!set.ok() || set.value().used) return Done{};
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << "UPDATE fault_set SET used = 1 WHERE id = :id", use(id, "id");
    return Done{};
  });
}

}  // namespace faultlab::server
