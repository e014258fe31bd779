#include "server/fault_sets/fault_sets.h"

#include <array>
#include <optional>

#include "server/storage/not_yours.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {

template <typename Visit>
void Fields(FaultSet& set, Visit&& visit) {
  visit("id", set.id);
  visit("course_id", set.course_id);
  visit("account_id", set.author);
  visit("name", set.name);
  visit("bench", set.bench);
  visit("version", set.version);
  visit("visible", set.visible);
  visit("faults", set.faults_json);
  visit("pool", set.pool_json);
  visit("used", set.used);
  visit("deleted", set.deleted);
  visit("replaces", set.replaces);
  visit("created_ms", set.created_at);
}

namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

Error Full() {
  return core::Refuse("fault_sets_full", "", {{"most", FaultSets::kOfAuthorMax}});
}
Error Changed() {
  return core::Refuse("fault_set_changed");
}

std::optional<FaultSet> Find(Transaction& tx, std::int64_t id) {
  return SelectRow<FaultSet>(tx, "fault_set WHERE deleted = 0 AND id = " + std::to_string(id));
}

FaultSet Insert(Transaction& tx, FaultSet set) {
  set.used = false;
  set.id = AddRow(tx, "fault_set", set);
  return set;
}

/// A used set is kept because its runs refer to it, but only the newest kOfAuthorMax of an author.
void Retire(Transaction& tx, const FaultSet& set) {
  UpdateWhere(tx, "fault_set", {{"deleted", 1}}, {{"id", set.id}});
  Execute(tx,
          "DELETE FROM fault_set WHERE account_id = :author AND deleted = 1 AND id <= "
          "(SELECT id FROM fault_set WHERE account_id = :author AND deleted = 1 "
          "ORDER BY id DESC LIMIT 1 OFFSET :kept)",
          {{"author", set.author}, {"kept", FaultSets::kOfAuthorMax}});
}

}  // namespace

core::Result<FaultSet> FaultSets::Create(FaultSet set) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<FaultSet> {
    TakeTurn(tx, "fault sets of " + std::to_string(set.author));
    const std::int64_t kept = CountRows(
        tx, "fault_set WHERE account_id = :author AND deleted = 0", {{"author", set.author}});
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
    constexpr std::array<std::string_view, 6> kChanged = {
        "name", "bench", "visible", "faults", "pool", "version"};
    ChangeRows(tx, "fault_set", next, kChanged, "id = :id", {{"id", set.id}});
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
      DeleteFrom(tx, "fault_set", {{"id", id}});
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
  std::string condition = "deleted = 0 AND id > " + std::to_string(after);
  if (reader) {
    const std::string me = "account_id = " + std::to_string(reader->account);
    const std::string courses = "course_id IN (SELECT course_id FROM enrolment WHERE " + me;
    condition += " AND ((visible = 1 AND " + courses + "))";
    if (reader->makes_sets) condition += " OR " + me + " OR " + courses + " AND teaches = 1)";
    condition += ")";
  }
  condition += " ORDER BY id LIMIT " + std::to_string(limit);
  return database_.Read(
      [&](Transaction& tx) { return SelectRows<FaultSet>(tx, "fault_set WHERE " + condition); });
}

core::Status FaultSets::MarkUsed(std::int64_t id) {
  // Most sets are marked already; then no write is needed, which would make others wait.
  const auto set = Get(id);
  if (!set.ok() && set.error().code != ErrorCode::kNotFound) return set.error();
  if (!set.ok() || set.value().used) return Done{};
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    UpdateWhere(tx, "fault_set", {{"used", 1}}, {{"id", id}});
  });
}

}  // namespace faultlab::server
