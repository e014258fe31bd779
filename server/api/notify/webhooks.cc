#include <algorithm>
#include <boost/json.hpp>

#include "server/api/notify/handlers.h"
#include "server/json/json_reader.h"
#include "server/storage/ids.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using notify::Kind;

json::object WebhookToJson(const notify::Webhook& hook) {
  json::array kinds;
  for (const Kind kind : hook.kinds) kinds.emplace_back(Name(kind));
  return {{"id", hook.id},
          {"url", hook.url},
          {"kinds", std::move(kinds)},
          {"created_at", Iso8601(hook.created)},
          {"delivered_at", TimeOrNull(hook.delivered)},
          {"failed_at", TimeOrNull(hook.failed)},
          {"error", hook.error},
          {"waiting", hook.waiting}};
}

std::set<Kind> ReadKindList(ObjectReader& in) {
  std::set<Kind> kinds;
  const json::array* const list = in.ArrayOrNull("kinds", notify::kKindCount);
  const bool words = list != nullptr && std::ranges::all_of(*list, [&](const json::value& each) {
                       const auto kind =
                           each.is_string() ? notify::ParseKind(each.get_string()) : std::nullopt;
                       if (kind) kinds.insert(*kind);
                       return kind.has_value();
                     });
  if (words && !kinds.empty()) return kinds;
  std::string known;
  for (int i = 0; i < notify::kKindCount; ++i) {
    known.append(known.empty() ? "" : ", ").append(Name(static_cast<Kind>(i)));
  }
  in.Refuse("kinds",
            "word_unknown",
            "'kinds' must be some of: " + known + ".",
            {{"member", "kinds"}, {"words", known}});
  return kinds;
}

std::string ObjectOf(std::int64_t id) {
  return "webhook:" + std::to_string(id);
}

}  // namespace

core::Result<HttpResponse> ListWebhooks(NotifyApi& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {});
  if (!query.ok()) return query.error();
  const auto hooks = api.webhooks.List();
  if (!hooks.ok()) return hooks.error();
  json::array items;
  for (const notify::Webhook& hook : hooks.value()) items.push_back(WebhookToJson(hook));
  return JsonResponse(json::object{{"items", std::move(items)}, {"next_cursor", nullptr}});
}

core::Result<HttpResponse> CreateWebhook(NotifyApi& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string url = in.Text("url", 2000);
  const std::set<Kind> kinds = ReadKindList(in);
  if (auto error = in.Finish()) return *error;
  const core::Status good = api.sender.CheckUrl(url);
  if (!good.ok()) return good.error();
  const auto made = api.webhooks.Add(url, kinds, api.clock.Wall());
  if (!made.ok()) return made.error();
  api.audit.Add(request.who, "create_webhook", ObjectOf(made.value().id), url);
  json::object answer = WebhookToJson(made.value());
  answer["secret"] = made.value().secret;
  return JsonResponse(answer, 201);
}

core::Result<HttpResponse> DeleteWebhook(NotifyApi& api, const ApiRequest& request) {
  const auto id = PathNumber(request);
  if (!id.ok()) return id.error();
  const auto hook = api.webhooks.Get(id.value());
  if (!hook.ok()) return hook.error();
  const core::Status removed = api.webhooks.Remove(id.value());
  if (!removed.ok()) return removed.error();
  api.audit.Add(request.who, "delete_webhook", ObjectOf(id.value()), hook.value().url);
  return NoContent();
}

/// Sent at once, past the outbox: the admin waits for the answer.
core::Result<HttpResponse> TestWebhook(NotifyApi& api, const ApiRequest& request) {
  const auto id = PathNumber(request);
  if (!id.ok()) return id.error();
  const auto hook = api.webhooks.Get(id.value());
  if (!hook.ok()) return hook.error();
  const WallTime now = api.clock.Wall();
  notify::Message message;
  message.delivery = NewId("msg");
  message.kind = notify::kTestKind;
  message.about = json::serialize(json::object{{"login", request.who.login}});
  message.created = now;
  const notify::Attempt attempt = api.sender.Send(hook.value(), message, now);
  const core::Status noted = api.webhooks.Note(id.value(), attempt.error, api.clock.Wall());
  if (!noted.ok()) return noted.error();
  return JsonResponse(json::object{{"taken", attempt.error.empty()}, {"error", attempt.error}});
}

}  // namespace faultlab::server
