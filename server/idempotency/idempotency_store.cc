#include "server/idempotency/idempotency_store.h"
#include "server/storage/rows.h"

#include <soci/soci.h>

namespace faultlab::server {
namespace {

using soci::into;
using soci::use;

constexpr auto kKept = std::chrono::hours(24);
constexpr auto kDeadAfter = std::chrono::minutes(10);

/// Drops the oldest answers. A request in progress stays, because it could be executed twice
/// otherwise.
void DropBeyondLimits(Transaction& tx, const std::string& owner) {
  const int answers = IdempotencyStore::kOfOwnerMax;
  const std::int64_t letters = IdempotencyStore::kLettersOfOwnerMax;
  tx.sql() << "DELETE FROM remembered_answer WHERE owner = :owner AND idempotency_key IN (SELECT "
              "idempotency_key FROM (SELECT idempotency_key, "
              "ROW_NUMBER() OVER (ORDER BY at_ms DESC, idempotency_key) AS place, "
              "SUM(LENGTH(body)) OVER (ORDER BY at_ms DESC, idempotency_key) AS letters "
              "FROM remembered_answer WHERE owner = :same AND status <> 0) newest "
              "WHERE place > :answers OR (place > 1 AND letters > :letters))",
      use(owner, "owner"), use(owner, "same"), use(answers, "answers"), use(letters, "letters");
}

}  // namespace

core::Result<std::optional<IdempotencyStore::Answer>> IdempotencyStore::Begin(
    const std::string& owner,
    const std::string& key,
    const std::string& request_hash,
    WallTime now) {
  using MaybeAnswer = std::optional<Answer>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<MaybeAnswer> {
    const std::int64_t now_ms = ToMilliseconds(now);
    const std::int64_t old_ms = ToMilliseconds(now - kKept);
    const std::int64_t dead_ms = ToMilliseconds(now - kDeadAfter);
    tx.sql()
        << "DELETE FROM remembered_answer WHERE at_ms < :old OR (status = 0 AND at_ms < :dead)",
        use(old_ms, "old"), use(dead_ms, "dead");
    if (Execute(tx,
                "INSERT INTO remembered_answer (owner, idempotency_key, request_hash, "
                "status, body, at_ms) VALUES (:owner, :key, :hash, 0, '', :now) "
                "ON CONFLICT (owner, idempotency_key) DO NOTHING",
                use(owner, "owner"),
                use(key, "key"),
                use(request_hash, "hash"),
                use(now_ms, "now")) == 1)
      return MaybeAnswer{};
    Answer answer;
    std::string hash;
    tx.sql() << "SELECT status, body, request_hash FROM remembered_answer WHERE owner = :owner "
                "AND idempotency_key = :key",
        into(answer.status), into(answer.body), into(hash), use(owner, "owner"), use(key, "key");
    if (hash != request_hash) {
      return core::Refuse("key_of_other_request", "Idempotency-Key");
    }
    if (answer.status == 0) {
      return core::Refuse("first_request_goes_on", "Idempotency-Key");
    }
    return MaybeAnswer{answer};
  });
}

core::Status IdempotencyStore::Finish(const std::string& owner,
                                      const std::string& key,
                                      int status,
                                      const std::string& body) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    tx.sql() << "UPDATE remembered_answer SET status = :status, body = :body WHERE owner = :owner "
                "AND idempotency_key = :key",
        use(status, "status"), use(body, "body"), use(owner, "owner"), use(key, "key");
    DropBeyondLimits(tx, owner);
  });
}

core::Status IdempotencyStore::Forget(const std::string& owner, const std::string& key) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    tx.sql() << "DELETE FROM remembered_answer WHERE owner = :owner AND idempotency_key = :key",
        use(owner, "owner"), use(key, "key");
  });
}

}  // namespace faultlab::server
