#include "server/idempotency/idempotency_store.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

constexpr auto kKept = std::chrono::hours(24);
constexpr auto kDeadAfter = std::chrono::minutes(10);

/// Drops the oldest answers. A request in progress stays, because it could be executed twice
/// otherwise.
void DropBeyondLimits(Transaction& tx, const std::string& owner) {
  Execute(tx,
          "DELETE FROM remembered_answer WHERE owner = :owner AND idempotency_key IN (SELECT "
          "idempotency_key FROM (SELECT idempotency_key, "
          "ROW_NUMBER() OVER (ORDER BY at_ms DESC, idempotency_key) AS place, "
          "SUM(LENGTH(body)) OVER (ORDER BY at_ms DESC, idempotency_key) AS letters "
          "FROM remembered_answer WHERE owner = :owner AND status <> 0) newest "
          "WHERE place > :answers OR (place > 1 AND letters > :letters))",
          {{"owner", owner},
           {"answers", IdempotencyStore::kOfOwnerMax},
           {"letters", IdempotencyStore::kLettersOfOwnerMax}});
}

}  // namespace

core::Result<std::optional<IdempotencyStore::Answer>> IdempotencyStore::Begin(
    const std::string& owner,
    const std::string& key,
    const std::string& request_hash,
    WallTime now) {
  using MaybeAnswer = std::optional<Answer>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<MaybeAnswer> {
    Execute(tx,
            "DELETE FROM remembered_answer WHERE at_ms < :old OR (status = 0 AND at_ms < :dead)",
            {{"old", now - kKept}, {"dead", now - kDeadAfter}});
    if (InsertInto(tx,
                   "remembered_answer",
                   {{"owner", owner},
                    {"idempotency_key", key},
                    {"request_hash", request_hash},
                    {"status", 0},
                    {"body", ""},
                    {"at_ms", now}},
                   "ON CONFLICT (owner, idempotency_key) DO NOTHING") == 1)
      return MaybeAnswer{};
    const auto [status, body, hash] = *SelectTuple<int, std::string, std::string>(
        tx,
        "SELECT status, body, request_hash FROM remembered_answer WHERE owner = :owner "
        "AND idempotency_key = :key",
        {{"owner", owner}, {"key", key}});
    if (hash != request_hash) {
      return core::Refuse("key_of_other_request", "Idempotency-Key");
    }
    if (status == 0) {
      return core::Refuse("first_request_goes_on", "Idempotency-Key");
    }
    return MaybeAnswer{{status, body}};
  });
}

core::Status IdempotencyStore::Finish(const std::string& owner,
                                      const std::string& key,
                                      int status,
                                      const std::string& body) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    UpdateWhere(tx,
                "remembered_answer",
                {{"status", status}, {"body", body}},
                {{"owner", owner}, {"idempotency_key", key}});
    DropBeyondLimits(tx, owner);
  });
}

core::Status IdempotencyStore::Forget(const std::string& owner, const std::string& key) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    DeleteFrom(tx, "remembered_answer", {{"owner", owner}, {"idempotency_key", key}});
  });
}

}  // namespace faultlab::server
