// auth/{login,logout,password,reset} and api-keys.
#include <boost/json.hpp>

#include "server/api/people/handlers.h"
#include "server/json/json_reader.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kSecretMax = 2048;

constexpr int kTwelveHours = 12 * 3600;
constexpr int kFourHundredDays = 400 * 24 * 3600;  // what browsers keep at most

json::object MeToJson(const Principal& who) {
  json::object out{{"role", Name(who.role)},
                   {"name", who.name},
                   {"login", who.login},
                   {"owner", who.owner_key()},
                   {"scopes", ListOf(who.scopes)}};
  if (!who.csrf_token.empty()) out["csrf_token"] = who.csrf_token;
  return out;
}

json::object KeyToJson(const ApiKey& key) {
  return {{"id", key.id},
          {"name", key.name},
          {"scopes", ListOf(key.scopes)},
          {"created_at", Iso8601(key.created_at)},
          {"expires_at", Iso8601(key.expires_at)},
          {"revoked", key.revoked}};
}

core::Result<HttpResponse> Me(Api&, const ApiRequest& request) {
  return JsonResponse(MeToJson(request.who));
}

core::Result<HttpResponse> SignIn(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string login = in.Text("login", kSecretMax);
  const std::string password = in.Text("password", kSecretMax);
  if (auto error = in.Finish()) return *error;
  const std::string_view device = CookieValue(request.http.Header("Cookie"), kDeviceCookieName);
  const SignInOutcome outcome = api.accounts.SignIn(
      {login, password, std::string(request.http.remote_address), std::string(device)},
      api.clock.Wall());
  if (outcome.note) api.audit.AddBounded(*outcome.note);
  if (!outcome.signed_in) return outcome.signed_in.error();
  const SignedIn& signed_in = outcome.signed_in.value();
  HttpResponse response = JsonResponse(MeToJson(signed_in.principal));
  AddSignInCookies(request, signed_in, response);
  return response;
}

core::Result<HttpResponse> SignOut(Api& api, const ApiRequest& request) {
  TRY_DONE(api.accounts.SignOut(request.who));
  api.audit.AddBounded({request.who, "sign_out", request.who.owner_key(), ""});
  HttpResponse response = NoContent();
  SetCookie(request, kSessionCookieName, "", 0, response);
  return response;
}

core::Result<HttpResponse> ChangePassword(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string before = in.Text("old", kSecretMax);
  const std::string after = in.Text("new", kSecretMax);
  const bool also_keys = in.BooleanOr("end_keys", false);
  if (auto error = in.Finish()) return *error;
  TRY_DONE(api.accounts.ChangePassword(request.who, before, after, also_keys, api.clock.Wall()));
  api.audit.Add(request.who,
                "change_password",
                request.who.owner_key(),
                also_keys ? "ended API keys and calendar link" : "");
  return NoContent();
}

/// Whose link it is. Nothing is used up, so that a scanner of mail which opens it spoils nothing.
core::Result<HttpResponse> ShowResetLink(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string token = in.Text("token", kSecretMax);
  if (auto error = in.Finish()) return *error;
  TRY(const auto owner, api.accounts.OwnerOfLink(token, api.clock.Wall()));
  return JsonResponse(json::object{{"login", owner.login}, {"name", owner.name}});
}

core::Result<HttpResponse> UseResetLink(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string token = in.Text("token", kSecretMax);
  const std::string password = in.Text("password", kSecretMax);
  if (auto error = in.Finish()) return *error;
  TRY(const auto account, api.accounts.UseLink(token, password, api.clock.Wall()));
  api.audit.Add(request.who,
                "use_reset_link",
                OwnerKeyOf(account),
                "from " + std::string(request.http.remote_address));
  return NoContent();
}

core::Result<HttpResponse> ListApiKeys(Api& api, const ApiRequest& request) {
  TRY(auto keys, api.accounts.ListKeys(request.who.user_id, api.clock.Wall()));
  return ListAnswer(ListOf(keys, KeyToJson));
}

core::Result<HttpResponse> CreateApiKey(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string name = in.Text("name", 200);
  std::set<std::string> scopes;
  if (const json::array* list = in.ArrayOrNull("scopes", kScopes.size())) {
    for (const json::value& scope : *list) {
      if (scope.is_string()) scopes.insert(std::string(scope.get_string()));
      if (!scope.is_string()) in.Refuse("scopes", "kind_wrong", {{"member", "scopes"}});
    }
  }
  const std::string expires = in.Text("expires_at", 40);
  if (auto error = in.Finish()) return *error;
  TRY(auto until, ParseIso8601(expires, "/expires_at"));
  TRY(auto made, api.accounts.CreateKey(request.who, name, scopes, until, api.clock.Wall()));
  json::object out = KeyToJson(made.key);
  out["key"] = made.secret;
  api.audit.Add(request.who, "create_key", "key:" + std::to_string(made.key.id), "");
  return JsonResponse(out, 201);
}

core::Result<HttpResponse> RevokeApiKey(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY_DONE(api.accounts.RevokeKey(request.who.user_id, id, api.clock.Wall()));
  api.audit.Add(request.who, "revoke_key", "key:" + std::to_string(id), "");
  return NoContent();
}

}  // namespace

void SetCookie(const ApiRequest& request,
               std::string_view name,
               const std::string& value,
               int age_s,
               HttpResponse& response) {
  response.headers.emplace_back("Set-Cookie",
                                std::string(name) + "=" + value +
                                    "; Path=/; HttpOnly; SameSite=Lax; Max-Age=" +
                                    std::to_string(age_s) + (request.http.https ? "; Secure" : ""));
}

void AddSignInCookies(const ApiRequest& request,
                      const SignedIn& signed_in,
                      HttpResponse& response) {
  SetCookie(request, kSessionCookieName, signed_in.cookie_secret, kTwelveHours, response);
  SetCookie(request, kDeviceCookieName, signed_in.device_secret, kFourHundredDays, response);
}

std::span<const ApiRoute> SignInRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "auth/me", kReadPublic, kRole, Me},
      {kPost, "auth/login", kReadPublic, kAnybody, SignIn, kSignInJson, kPassword},
      {kPost, "auth/reset", kReadPublic, kAnybody, UseResetLink, kSignInJson, kPassword},
      {kPost, "auth/reset/owner", kReadPublic, kAnybody, ShowResetLink, kSignInJson},
      {kPost, "auth/logout", kManageOwnAccount, kRole, SignOut, kEmpty},
      {kPost, "auth/password", kManageOwnAccount, kRole, ChangePassword, kPasswords, kPassword},
      {kGet, "api-keys", kManageOwnAccount, kRole, ListApiKeys},
      {kPost, "api-keys", kManageOwnAccount, kRole, CreateApiKey, kJsonForSecret},
      {kDelete, "api-keys/{id}", kManageOwnAccount, kRole, RevokeApiKey},
  });
  return kRoutes;
}

}  // namespace faultlab::server
