#include "server/auth/calendar_links.h"

#include "server/auth/secrets.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;

Error NoLink() {
  return core::Refuse("no_calendar");
}

}  // namespace

core::Result<std::string> CalendarLinks::Create(std::int64_t account_id, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::string secret = NewSecret("flc_");
    InsertInto(
        tx,
        "calendar_link",
        {{"account_id", account_id}, {"token_hash", HashSecret(secret)}, {"created_ms", now}},
        "ON CONFLICT (account_id) DO UPDATE SET token_hash = excluded.token_hash, "
        "created_ms = excluded.created_ms");
    return secret;
  });
}

core::Status CalendarLinks::Remove(std::int64_t account_id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (DeleteFrom(tx, "calendar_link", {{"account_id", account_id}}) == 0) return NoLink();
    return Done{};
  });
}

core::Result<std::optional<WallTime>> CalendarLinks::CreatedAt(std::int64_t account_id) {
  return database_.Read([&](Transaction& tx) {
    return SelectValue<WallTime>(tx,
                                 "SELECT created_ms FROM calendar_link WHERE account_id = :account",
                                 {{"account", account_id}});
  });
}

core::Result<std::int64_t> CalendarLinks::AccountOf(const std::string& secret) {
  return database_.Read([&](Transaction& tx) -> core::Result<std::int64_t> {
    const auto account = SelectValue<std::int64_t>(
        tx,
        "SELECT c.account_id FROM calendar_link c JOIN account a ON a.id = c.account_id "
        "WHERE c.token_hash = :hash AND a.disabled = 0",
        {{"hash", HashSecret(secret)}});
    if (!account) return NoLink();
    return *account;
  });
}

}  // namespace faultlab::server
