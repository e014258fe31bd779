#include "server/notify/webhooks.h"

#include <soci/soci.h>

#include "server/notify/signature.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::notify {
namespace {

using core::Done;
using core::Error;
using soci::into;
using soci::use;

std::optional<WallTime> TimeOf(std::int64_t ms) {
  return ms == 0 ? std::nullopt : std::optional(FromMilliseconds(ms));
}

Error NoWebhook() {
  return core::Refuse("no_webhook");
}

}  // namespace

std::vector<Webhook> LoadWebhooks(Transaction& tx) {
  Webhook row;
  std::string kinds;
  std::int64_t created_ms = 0;
  std::int64_t delivered_ms = 0;
  std::int64_t failed_ms = 0;
  soci::statement statement =
      (tx.sql().prepare << "SELECT w.id, w.url, w.secret, w.kinds, w.created_ms, w.delivered_ms, "
                           "w.failed_ms, w.error, (SELECT COUNT(*) FROM outbox o WHERE "
                           "o.channel = 'hook:' || w.id AND o.state = 'waiting') "
                           "FROM webhook w ORDER BY w.id",
       into(row.id),
       into(row.url),
       into(row.secret),
       into(kinds),
       into(created_ms),
       into(delivered_ms),
       into(failed_ms),
       into(row.error),
       into(row.waiting));
  statement.execute(false);
  std::vector<Webhook> out;
  while (statement.fetch()) {
    row.kinds = ReadKinds(kinds);
    row.created = FromMilliseconds(created_ms);
    row.delivered = TimeOf(delivered_ms);
    row.failed = TimeOf(failed_ms);
    out.push_back(row);
  }
  return out;
}

core::Result<Webhook> Webhooks::Add(const std::string& url,
                                    const std::set<Kind>& kinds,
                                    WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Webhook> {
    TakeTurn(tx, "webhooks");
    int count = 0;
    tx.sql() << "SELECT COUNT(*) FROM webhook", into(count);
    if (count >= kMax) {
      return core::Refuse("webhooks_full", "", {{"most", kMax}});
    }
    Webhook hook;
    hook.url = url;
    hook.secret = NewHookSecret();
    hook.kinds = kinds;
    hook.created = now;
    const std::string words = WriteKinds(kinds);
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "INSERT INTO webhook (url, secret, kinds, created_ms, delivered_ms, failed_ms, "
                "error) VALUES (:url, :secret, :kinds, :now, 0, 0, '') RETURNING id",
        use(hook.url, "url"), use(hook.secret, "secret"), use(words, "kinds"), use(now_ms, "now"),
        into(hook.id);
    return hook;
  });
}

core::Result<std::vector<Webhook>> Webhooks::List() {
  return database_.Read(
      [](Transaction& tx) -> core::Result<std::vector<Webhook>> { return LoadWebhooks(tx); });
}

core::Result<Webhook> Webhooks::Get(std::int64_t id) {
  TRY(auto all, List());
  for (Webhook& each : all) {
    if (each.id == id) return std::move(each);
  }
  return NoWebhook();
}

core::Status Webhooks::Remove(std::int64_t id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (Execute(tx, "DELETE FROM webhook WHERE id = :id", use(id, "id")) == 0) return NoWebhook();
    const std::string channel = HookChannel(id);
    tx.sql() << "DELETE FROM outbox WHERE channel = :channel", use(channel, "channel");
    return Done{};
  });
}

core::Status Webhooks::Note(std::int64_t id, const std::string& error, WallTime now) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) {
    const std::int64_t now_ms = ToMilliseconds(now);
    if (error.empty()) {
      tx.sql() << "UPDATE webhook SET delivered_ms = :now WHERE id = :id", use(now_ms, "now"),
          use(id, "id");
    } else {
      tx.sql() << "UPDATE webhook SET failed_ms = :now, error = :error WHERE id = :id",
          use(now_ms, "now"), use(error, "error"), use(id, "id");
    }
  });
}

}  // namespace faultlab::server::notify
