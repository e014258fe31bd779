#include "server/auth/calendar_links.h"

#include <soci/soci.h>

#include "server/auth/secrets.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using soci::into;
using soci::use;

Error NoLink() {
  return core::Refuse("no_calendar");
}

}  // namespace

core::Result<std::string> CalendarLinks::Create(std::int64_t account_id, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::string secret = NewSecret("flc_");
    const std::string hash = HashSecret(secret);
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "INSERT INTO calendar_link (account_id, token_hash, created_ms) "
                "VALUES (:account, :hash, :now) ON CONFLICT (account_id) DO UPDATE SET "
                "token_hash = excluded.token_hash, created_ms = excluded.created_ms",
        use(account_id, "account"), use(hash, "hash"), use(now_ms, "now");
    return secret;
  });
}

core::Status CalendarLinks::Remove(std::int64_t account_id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (Execute(tx,
                "DELETE FROM calendar_link WHERE account_id = :account",
                use(account_id, "account")) == 0)
      return NoLink();
    return Done{};
  });
}

core::Result<std::optional<WallTime>> CalendarLinks::CreatedAt(std::int64_t account_id) {
  using MaybeTime = std::optional<WallTime>;
  return database_.Read([&](Transaction& tx) -> core::Result<MaybeTime> {
    std::int64_t created_ms = 0;
    tx.sql() << "SELECT created_ms FROM calendar_link WHERE account_id = :account",
        into(created_ms), use(account_id, "account");
    if (!tx.sql().got_data()) return MaybeTime{};
    return MaybeTime{FromMilliseconds(created_ms)};
  });
}

core::Result<std::int64_t> CalendarLinks::AccountOf(const std::string& secret) {
  return database_.Read([&](Transaction& tx) -> core::Result<std::int64_t> {
    const std::string hash = HashSecret(secret);
    std::int64_t account = 0;
    tx.sql() << "SELECT c.account_id FROM calendar_link c JOIN account a ON a.id = c.account_id "
                "WHERE c.token_hash = :hash AND a.disabled = 0",
        into(account), use(hash, "hash");
    if (!tx.sql().got_data()) return NoLink();
    return account;
  });
}

}  // namespace faultlab::server
