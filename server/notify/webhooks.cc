#include "server/notify/webhooks.h"

#include "server/notify/signature.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::notify {

template <typename Visit>
void Fields(Webhook& hook, Visit&& visit) {
  visit("id", hook.id);
  visit("account_id", hook.account);
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
  return SelectRows<Webhook>(
      tx,
      "webhook WHERE account_id = 0 OR account_id IN (SELECT id FROM account "
      "WHERE disabled = 0) ORDER BY id");
}

core::Result<Webhook> Webhooks::Add(std::int64_t account,
                                    const std::string& url,
                                    const std::set<Kind>& kinds,
                                    WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Webhook> {
    TakeTurn(tx, "webhooks");
    const int most = account == 0 ? kMax : kOfPersonMax;
    if (CountRows(tx, "webhook WHERE account_id = :account", {{"account", account}}) >= most) {
      return core::Refuse("webhooks_full", "", {{"most", most}});
    }
    Webhook hook;
    hook.account = account;
    hook.url = url;
    hook.secret = NewHookSecret();
    hook.kinds = kinds;
    hook.created = now;
    hook.id = AddRow(tx, "webhook", hook);
    return hook;
  });
}

core::Result<std::vector<Webhook>> Webhooks::List(std::int64_t account, bool labs) {
  return database_.Read([&](Transaction& tx) -> core::Result<std::vector<Webhook>> {
    auto hooks = SelectRows<Webhook>(tx,
                                     "webhook WHERE account_id IN (:account, :labs) ORDER BY id",
                                     {{"account", account}, {"labs", labs ? 0 : account}});
    for (Webhook& hook : hooks) {
      hook.waiting = CountRows(tx,
                               "outbox WHERE channel = :channel AND state = 'waiting'",
                               {{"channel", HookChannel(hook.id)}});
    }
    return hooks;
  });
}

core::Result<Webhook> Webhooks::Get(std::int64_t id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Webhook> {
    const auto found =
        SelectRow<Webhook>(tx,
                           "webhook WHERE id = :id AND (account_id = 0 OR account_id "
                           "IN (SELECT id FROM account WHERE disabled = 0))",
                           {{"id", id}});
    if (!found) return NoWebhook();
    return *found;
  });
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
