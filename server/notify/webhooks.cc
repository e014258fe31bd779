#include "server/notify/webhooks.h"

#include "server/notify/signature.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::notify {

template <typename Visit>
void Fields(Webhook& hook, Visit&& visit) {
  visit("id", hook.id);
  visit("url", hook.url);
  visit("secret", hook.secret);
  visit("kinds", hook.kinds, KindsText{});
  visit("created_ms", hook.created);
  visit("delivered_ms", hook.delivered);
  visit("failed_ms", hook.failed);
  visit("error", hook.error);
}

namespace {

using core::Done;
using core::Error;

Error NoWebhook() {
  return core::Refuse("no_webhook");
}

}  // namespace

std::vector<Webhook> LoadWebhooks(Transaction& tx) {
  auto hooks = SelectRows<Webhook>(tx, "webhook ORDER BY id");
  for (Webhook& hook : hooks) {
    hook.waiting = CountRows(tx,
                             "outbox WHERE channel = :channel AND state = 'waiting'",
                             {{"channel", HookChannel(hook.id)}});
  }
  return hooks;
}

core::Result<Webhook> Webhooks::Add(const std::string& url,
                                    const std::set<Kind>& kinds,
                                    WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Webhook> {
    TakeTurn(tx, "webhooks");
    if (CountRows(tx, "webhook") >= kMax) {
      return core::Refuse("webhooks_full", "", {{"most", kMax}});
    }
    Webhook hook;
    hook.url = url;
    hook.secret = NewHookSecret();
    hook.kinds = kinds;
    hook.created = now;
    hook.id = AddRow(tx, "webhook", hook);
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
    if (DeleteFrom(tx, "webhook", {{"id", id}}) == 0) return NoWebhook();
    DeleteFrom(tx, "outbox", {{"channel", HookChannel(id)}});
    return Done{};
  });
}

core::Status Webhooks::Note(std::int64_t id, const std::string& error, WallTime now) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) {
    if (error.empty()) {
      UpdateWhere(tx, "webhook", {{"delivered_ms", now}}, {{"id", id}});
    } else {
      UpdateWhere(tx, "webhook", {{"failed_ms", now}, {"error", error}}, {{"id", id}});
    }
  });
}

}  // namespace faultlab::server::notify
