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
          {"of", hook.account == 0 ? "lab" : "me"},
          {"url", hook.url},
          {"kinds", ListOf(hook.kinds, [](Kind kind) { return Name(kind); })},
          {"created_at", Iso8601(hook.created)},
          {"delivered_at", TimeOrNull(hook.delivered)},
          {"failed_at", TimeOrNull(hook.failed)},
          {"error", hook.error},
          {"waiting", hook.waiting}};
}

std::set<Kind> ReadKindList(ObjectReader& in, bool person) {
  std::set<Kind> kinds;
  const json::array* const list = in.ArrayOrNull("kinds", notify::kKindCount);
  const bool words = list != nullptr && std::ranges::all_of(*list, [&](const json::value& each) {
                       const auto kind =
                           each.is_string() ? notify::ParseKind(each.get_string()) : std::nullopt;
                       const bool may = kind && notify::IsFor(*kind, person);
                       if (may) kinds.insert(*kind);
                       return may;
                     });
  if (words && !kinds.empty()) return kinds;
  std::string known;
  for (int i = 0; i < notify::kKindCount; ++i) {
    const auto kind = static_cast<Kind>(i);
    if (notify::IsFor(kind, person)) known.append(known.empty() ? "" : ", ").append(Name(kind));
  }
  in.Refuse("kinds", "words_unknown", {{"member", "kinds"}, {"words", known}});
  return kinds;
}

std::string ObjectOf(std::int64_t id) {
  return "webhook:" + std::to_string(id);
}

/// For the log: the rest of an address may be a secret.
std::string HostOf(const std::string& url) {
  const std::size_t host = url.find("//");
  return url.substr(0, host == std::string::npos ? host : url.find('/', host + 2));
}

/// Those of the lab are an admin's, who is signed in: a key has those of its account.
bool HasLabs(const ApiRequest& request) {
  return Authorize(request.who, Operation::kManageWebhooks, Ownership::kForeign).ok();
}

/// One that the caller may change.
core::Result<notify::Webhook> HookOf(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(auto hook, api.webhooks.Get(id));
  const bool own = hook.account == request.who.user_id;
  if (own || (hook.account == 0 && HasLabs(request))) return hook;
  return core::Refuse("no_webhook");
}

core::Result<HttpResponse> ListWebhooks(Api& api, const ApiRequest& request) {
  TRY(const auto hooks, api.webhooks.List(request.who.user_id, HasLabs(request)));
  return ListAnswer(ListOf(hooks, WebhookToJson));
}

core::Result<HttpResponse> CreateWebhook(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string url = in.Text("url", 2000);
  const bool mine = in.WordOr("of", HasLabs(request) ? "lab" : "me", {"me", "lab"}) == "me";
  const std::set<Kind> kinds = ReadKindList(in, mine);
  if (auto error = in.Finish()) return *error;
  if (!mine) TRY_DONE(Authorize(request.who, Operation::kManageWebhooks, Ownership::kNone));
  TRY_DONE(api.hook_sender.CheckUrl(url));
  TRY(const auto made,
      api.webhooks.Add(mine ? request.who.user_id : 0, url, kinds, api.clock.Wall()));
  api.audit.Add(request.who, "create_webhook", ObjectOf(made.id), HostOf(url));
  json::object answer = WebhookToJson(made);
  answer["secret"] = made.secret;
  return JsonResponse(answer, 201);
}

core::Result<HttpResponse> DeleteWebhook(Api& api, const ApiRequest& request) {
  TRY(const auto hook, HookOf(api, request));
  TRY_DONE(api.webhooks.Remove(hook.id));
  api.audit.Add(request.who, "delete_webhook", ObjectOf(hook.id), HostOf(hook.url));
  return NoContent();
}

/// Sent at once, past the outbox: whoever asks waits for the answer.
core::Result<HttpResponse> TestWebhook(Api& api, const ApiRequest& request) {
  TRY(const auto hook, HookOf(api, request));
  const WallTime now = api.clock.Wall();
  notify::Message message;
  message.delivery = NewId("msg");
  message.kind = notify::kTestKind;
  message.about = json::serialize(json::object{{"login", request.who.login}});
  message.created = now;
  const notify::Attempt attempt = api.hook_sender.Send(hook, message, now);
  TRY_DONE(api.webhooks.Note(hook.id, attempt.error, api.clock.Wall()));
  return JsonResponse(json::object{{"taken", attempt.error.empty()}, {"error", attempt.error}});
}

}  // namespace

std::span<const ApiRoute> WebhooksRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "webhooks", kUseWebhook, kRole, ListWebhooks},
      {kPost, "webhooks", kUseWebhook, kRole, CreateWebhook, kJsonForSecret},
      {kDelete, "webhooks/{id}", kUseWebhook, kRole, DeleteWebhook},
      {kPost, "webhooks/{id}/test", kUseWebhook, kRole, TestWebhook, kEmpty, kOutside},
  });
  return kRoutes;
}

}  // namespace faultlab::server
