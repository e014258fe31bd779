#include <algorithm>
#include <boost/json.hpp>

#include "server/api/api.h"
#include "server/json/json_reader.h"
#include "server/storage/ids.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using notify::Kind;

json::object WebhookToJson(const notify::Webhook& hook) {
  return {{"id", hook.id},
          {"url", hook.url},
          {"kinds", ListOf(hook.kinds, [](Kind kind) { return Name(kind); })},
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
  in.Refuse("kinds", "words_unknown", {{"member", "kinds"}, {"words", known}});
  return kinds;
}

std::string ObjectOf(std::int64_t id) {
  return "webhook:" + std::to_string(id);
}

core::Result<HttpResponse> ListWebhooks(Api& api, const ApiRequest&) {
  TRY(const auto hooks, api.webhooks.List());
  return ListAnswer(ListOf(hooks, WebhookToJson));
}

core::Result<HttpResponse> CreateWebhook(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string url = in.Text("url", 2000);
  const std::set<Kind> kinds = ReadKindList(in);
  if (auto error = in.Finish()) return *error;
  TRY_DONE(api.hook_sender.CheckUrl(url));
  TRY(const auto made, api.webhooks.Add(url, kinds, api.clock.Wall()));
  api.audit.Add(request.who, "create_webhook", ObjectOf(made.id), url);
  json::object answer = WebhookToJson(made);
  answer["secret"] = made.secret;
  return JsonResponse(answer, 201);
}

core::Result<HttpResponse> DeleteWebhook(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto hook, api.webhooks.Get(id));
  TRY_DONE(api.webhooks.Remove(id));
  api.audit.Add(request.who, "delete_webhook", ObjectOf(id), hook.url);
  return NoContent();
}

/// Sent at once, past the outbox: the admin waits for the answer.
core::Result<HttpResponse> TestWebhook(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto hook, api.webhooks.Get(id));
  const WallTime now = api.clock.Wall();
  notify::Message message;
  message.delivery = NewId("msg");
  message.kind = notify::kTestKind;
  message.about = json::serialize(json::object{{"login", request.who.login}});
  message.created = now;
  const notify::Attempt attempt = api.hook_sender.Send(hook, message, now);
  TRY_DONE(api.webhooks.Note(id, attempt.error, api.clock.Wall()));
  return JsonResponse(json::object{{"taken", attempt.error.empty()}, {"error", attempt.error}});
}

}  // namespace

std::span<const ApiRoute> WebhooksRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "webhooks", kManageWebhooks, kRole, ListWebhooks},
      {kPost, "webhooks", kManageWebhooks, kRole, CreateWebhook, kJsonForSecret},
      {kDelete, "webhooks/{id}", kManageWebhooks, kRole, DeleteWebhook},
      {kPost, "webhooks/{id}/test", kManageWebhooks, kRole, TestWebhook, kEmpty, kOutside},
  });
  return kRoutes;
}

}  // namespace faultlab::server
