// lti/platforms, lti/invitations, lti/register: the learning platforms whose links are accepted.
#include <boost/json.hpp>

#include "server/address_key.h"
#include "server/api/api.h"
#include "server/api/people/handlers.h"
#include "server/api/people/lti_page.h"
#include "server/json/json_reader.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;

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

core::Result<HttpResponse> ListPlatforms(Api& api, const ApiRequest& request) {
  TRY(const auto platforms, api.platforms.List());
  const lti::ToolAddresses tool = lti::ToolAt(BaseUrl(api, request));
  return JsonResponse(json::object{
      {"items", ListOf(platforms, PlatformToJson)},
      {"tool", {{"login_url", tool.login}, {"launch_url", tool.launch}, {"keys_url", tool.keys}}}});
}

core::Result<lti::Platform> ReadPlatform(const Api& api, const ApiRequest& request) {
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
  TRY_DONE(api.platform_client.CheckUrl(platform.auth_url, "/auth_url"));
  TRY_DONE(api.platform_client.CheckUrl(platform.token_url, "/token_url"));
  TRY_DONE(api.platform_client.CheckUrl(platform.keys_url, "/keys_url"));
  platform.created = api.clock.Wall();
  return platform;
}

void Note(Api& api, const Principal& who, const char* verb, const lti::Platform& platform) {
  api.audit.Add(
      who, verb, "platform:" + std::to_string(platform.id), platform.label + " " + platform.issuer);
}

core::Result<HttpResponse> CreatePlatform(Api& api, const ApiRequest& request) {
  TRY(const auto platform, ReadPlatform(api, request));
  TRY(const auto made, api.platforms.Add(platform));
  Note(api, request.who, "create_platform", made);
  return JsonResponse(PlatformToJson(made), 201);
}

core::Result<HttpResponse> PutPlatform(Api& api, const ApiRequest& request) {
  TRY(auto platform, ReadPlatform(api, request));
  TRY(platform.id, PathNumber(request));
  TRY(const auto kept, api.platforms.Put(platform));
  Note(api, request.who, "change_platform", kept);
  return JsonResponse(PlatformToJson(kept));
}

/// Whoever has this address may register one platform within an hour.
core::Result<HttpResponse> InvitePlatform(Api& api, const ApiRequest& request) {
  return JsonResponse(
      json::object{{"url",
                    BaseUrl(api, request) + "/api/v1/lti/register/" +
                        api.registration.Invite(request.who.user_id)},
                   {"expires_at", Iso8601(api.clock.Wall() + lti::Registration::kLives)}});
}

/// A platform's admin has opened the address there.
core::Result<lti::Platform> Register(Api& api, const ApiRequest& request) {
  TRY(const auto invitation, api.registration.Open(request.http.PathParameter("invitation")));
  const auto admin = api.accounts.Get(invitation.admin);
  if (!admin && admin.error().code != ErrorCode::kNotFound) return admin.error();
  if (!admin || admin.value().disabled || admin.value().role != Role::kAdmin) {
    return Error{ErrorCode::kForbidden, "its admin is gone", "", "lti_register_over"};
  }
  TRY(const auto offer,
      api.registration.Read(request.http.Query("openid_configuration").value_or("")));
  TRY_DONE(api.platforms.CheckRoom());
  if (const auto once = api.accounts.UseOnce(invitation.state, api.clock.Wall()); !once.ok()) {
    if (once.error().code != ErrorCode::kForbidden) return once.error();
    return Error{ErrorCode::kForbidden, "the address was used", "", "lti_register_over"};
  }
  TRY(const auto platform,
      api.registration.Enter(offer,
                             request.http.Query("registration_token").value_or(""),
                             lti::ToolAt(BaseUrl(api, request))));
  TRY(const auto made, api.platforms.Add(platform));
  Note(api, PrincipalOf(admin.value()), "create_platform", made);
  return made;
}

/// There is nothing to click, and a platform's pages may lie at several hosts.
constexpr const char* kAnyFrame = "*";
/// The platform waits for this; whose hash is told.
constexpr const char* kDone =
    "(window.opener||window.parent).postMessage({subject:\"org.imsglobal.lti.close\"},\"*\")";
constexpr const char* kDoneHash = "'sha256-+vyo9vRR6KatVjVPnRwydqjx2SIs9Sj2BRF5BAUspcg='";

core::Result<HttpResponse> RegisterPlatform(Api& api, const ApiRequest& request) {
  const std::string network = AddressKey(request.http.remote_address);
  if (const auto patience = api.failed_launches.Try(network, api.clock.Wall()); !patience.ok()) {
    return RefusePlainly(api, request, patience.error(), kAnyFrame);
  }
  const auto made = Register(api, request);
  if (!made) return RefusePlainly(api, request, made.error(), kAnyFrame);
  api.failed_launches.Forgive(network);
  return PlainPage(request,
                   200,
                   "lti_registered",
                   {.more = "<script>" + std::string(kDone) + "</script>",
                    .script = kDoneHash,
                    .frame = kAnyFrame});
}

core::Result<HttpResponse> DeletePlatform(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto platform, api.platforms.Get(id));
  TRY_DONE(api.platforms.Remove(id));
  Note(api, request.who, "delete_platform", platform);
  return NoContent();
}

/// Asked at once: the admin waits for the answer.
core::Result<HttpResponse> TestPlatform(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto platform, api.platforms.Get(id));
  const auto keys = api.platform_client.CountKeys(platform);
  const core::Status token = api.platform_client.CheckToken(platform);
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
      {kPut, "lti/platforms/{id}", kManageWebhooks, kRole, PutPlatform, kJson},
      {kPost, "lti/invitations", kManageWebhooks, kRole, InvitePlatform, kEmptyForSecret},
      ApiRoute{kGet,
               "lti/register/{invitation}",
               kReadPublic,
               kAnybody,
               RegisterPlatform,
               kNoBody,
               kOutside}
          .Takes("*"),
      {kDelete, "lti/platforms/{id}", kManageWebhooks, kRole, DeletePlatform},
      {kPost, "lti/platforms/{id}/test", kManageWebhooks, kRole, TestPlatform, kEmpty, kOutside},
      {kGet, "lti/platforms/{id}/grades", kManageWebhooks, kRole, ListSentGrades},
  });
  return kRoutes;
}

}  // namespace faultlab::server
