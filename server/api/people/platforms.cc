// lti/platforms: the learning platforms whose links are accepted, as an admin registers them.
#include <boost/json.hpp>

#include "server/api/api.h"
#include "server/api/people/handlers.h"
#include "server/json/json_reader.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr int kSentShown = 200;

json::object PlatformToJson(const lti::Platform& platform) {
  return {{"id", platform.id},
          {"label", platform.label},
          {"issuer", platform.issuer},
          {"client_id", platform.client_id},
          {"deployment", platform.deployment},
          {"auth_url", platform.auth_url},
          {"token_url", platform.token_url},
          {"keys_url", platform.keys_url},
          {"makes_teachers", platform.makes_teachers},
          {"claims_class_lists", platform.claims_class_lists},
          {"created_at", Iso8601(platform.created)}};
}

std::string PlatformKey(std::int64_t id) {
  return "platform:" + std::to_string(id);
}

core::Result<HttpResponse> ListPlatforms(Api& api, const ApiRequest& request) {
  TRY(const auto platforms, api.platforms.List());
  const std::string base = BaseUrl(api, request) + "/api/v1/lti/";
  return JsonResponse(json::object{{"items", ListOf(platforms, PlatformToJson)},
                                   {"tool",
                                    {{"login_url", base + "login"},
                                     {"launch_url", base + "launch"},
                                     {"keys_url", base + "keys"}}}});
}

core::Result<HttpResponse> CreatePlatform(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  lti::Platform platform;
  platform.label = in.Text("label", 200);
  platform.issuer = in.Text("issuer", 500);
  platform.client_id = in.Text("client_id", 200);
  platform.deployment = in.TextOr("deployment", "", 200);
  platform.auth_url = in.Text("auth_url", 2000);
  platform.token_url = in.Text("token_url", 2000);
  platform.keys_url = in.Text("keys_url", 2000);
  platform.makes_teachers = in.BooleanOr("makes_teachers", false);
  platform.claims_class_lists = in.BooleanOr("claims_class_lists", false);
  if (auto error = in.Finish()) return *error;
  TRY_DONE(api.launches.CheckUrl(platform.auth_url, "/auth_url"));
  TRY_DONE(api.launches.CheckUrl(platform.token_url, "/token_url"));
  TRY_DONE(api.launches.CheckUrl(platform.keys_url, "/keys_url"));
  platform.created = api.clock.Wall();
  TRY(const auto made, api.platforms.Add(platform));
  api.audit.Add(
      request.who, "create_platform", PlatformKey(made.id), made.label + " " + made.issuer);
  return JsonResponse(PlatformToJson(made), 201);
}

core::Result<HttpResponse> DeletePlatform(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto platform, api.platforms.Get(id));
  TRY_DONE(api.platforms.Remove(id));
  api.audit.Add(
      request.who, "delete_platform", PlatformKey(id), platform.label + " " + platform.issuer);
  return NoContent();
}

/// Asked at once: the admin waits for the answer.
core::Result<HttpResponse> TestPlatform(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto platform, api.platforms.Get(id));
  const auto keys = api.launches.CountKeys(platform);
  const core::Status token = api.grade_sender.CheckToken(platform);
  return JsonResponse(
      json::object{{"keys", keys.ok() ? static_cast<std::int64_t>(keys.value()) : 0},
                   {"keys_error", keys.ok() ? "" : keys.error().message},
                   {"token", token.ok()},
                   {"token_error", token.ok() ? "" : token.error().message}});
}

core::Result<HttpResponse> ListSentGrades(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY_DONE(api.platforms.Get(id));
  TRY(const auto sent, api.platforms.SentTo(id, kSentShown));
  return ListAnswer(ListOf(sent, [&](const lti::Platforms::Sent& each) {
    const auto account = api.accounts.Get(each.account);
    return json::object{{"login", account ? json::value(account.value().login) : nullptr},
                        {"assignment", each.assignment},
                        {"at", Iso8601(each.at)},
                        {"state", each.state},
                        {"attempts", each.attempts},
                        {"error", each.error}};
  }));
}

}  // namespace

std::span<const ApiRoute> PlatformsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "lti/platforms", kManageWebhooks, kRole, ListPlatforms},
      {kPost, "lti/platforms", kManageWebhooks, kRole, CreatePlatform, kJson},
      {kDelete, "lti/platforms/{id}", kManageWebhooks, kRole, DeletePlatform},
      {kPost, "lti/platforms/{id}/test", kManageWebhooks, kRole, TestPlatform, kEmpty, kOutside},
      {kGet, "lti/platforms/{id}/grades", kManageWebhooks, kRole, ListSentGrades},
  });
  return kRoutes;
}

}  // namespace faultlab::server
