// auth/providers, auth/oidc/{id}/{start,callback,link}, auth/identities.
#include "server/api/api.h"

#include <boost/json.hpp>

#include "server/address_key.h"
#include "server/api/people/handlers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;

/// A browser that reaches us by https takes a cookie of the second name from this host alone.
constexpr std::string_view kLoginCookie = "faultlab_login";
constexpr std::string_view kLoginCookieOfHost = "__Host-faultlab_login";
constexpr int kLoginCookieS = 600;

std::string_view LoginCookie(const ApiRequest& request) {
  return request.http.https ? kLoginCookieOfHost : kLoginCookie;
}

std::string RedirectUri(const Api& api, const ApiRequest& request, const std::string& provider) {
  return BaseUrl(api, request) + "/api/v1/auth/oidc/" + provider + "/callback";
}

/// The sign-in page says why in the reader's language; the details are the operator's.
HttpResponse Refuse(Api& api,
                    const ApiRequest& request,
                    const std::string& provider,
                    const Error& error,
                    bool adding) {
  const std::string address(request.http.remote_address);
  const std::string reason = error.reason.empty() ? "oidc_failed" : error.reason;
  if (api.refusal_lines.Try(AddressKey(address), api.clock.Wall()).ok()) {
    api.log("sign-in by " + provider + " from " + address + ": " + reason + ": " + error.message);
  }
  api.audit.AddBounded(
      {Principal{}, "sign_in_failed", "provider:" + provider, "from " + address + ": " + reason});
  return GoTo(std::string(adding ? "/account" : "/signin") + "?failed=" + reason);
}

core::Result<oidc::Provider*> ProviderOf(Api& api, const ApiRequest& request) {
  oidc::Provider* provider = api.sign_in_flow.Find(request.http.PathParameter("id"));
  if (provider == nullptr) return core::Refuse("no_provider");
  return provider;
}

core::Result<HttpResponse> ListProviders(Api& api, const ApiRequest&) {
  const auto to_json = [](const auto& provider) {
    const oidc::ProviderSettings& settings = provider->settings();
    return json::object{{"id", settings.id}, {"label", settings.label}};
  };
  return JsonResponse(json::object{{"items", ListOf(api.sign_in_flow.providers(), to_json)}});
}

core::Result<HttpResponse> StartSignIn(Api& api, const ApiRequest& request) {
  TRY(auto provider, ProviderOf(api, request));
  const std::string& id = provider->settings().id;
  auto departure = api.sign_in_flow.Begin(
      id, RedirectUri(api, request, id), std::string(request.http.Query("next").value_or("")), 0);
  if (!departure) return Refuse(api, request, id, departure.error(), /*adding=*/false);
  HttpResponse response = GoTo(departure.value().location);
  SetCookie(request, LoginCookie(request), departure.value().sealed, kLoginCookieS, response);
  return response;
}

core::Result<HttpResponse> StartLink(Api& api, const ApiRequest& request) {
  TRY(auto provider, ProviderOf(api, request));
  const std::string& id = provider->settings().id;
  auto departure =
      api.sign_in_flow.Begin(id, RedirectUri(api, request, id), "/account", request.who.user_id);
  if (!departure) {
    api.log("provider " + id + ": " + departure.error().message);
    return core::Refuse("provider_away");
  }
  HttpResponse response = JsonResponse(json::object{{"location", departure.value().location}});
  SetCookie(request, LoginCookie(request), departure.value().sealed, kLoginCookieS, response);
  return response;
}

/// Whoever began it must still be signed in, in this browser.
core::Status AddIdentity(Api& api,
                         const ApiRequest& request,
                         std::int64_t account,
                         const VouchedPerson& person) {
  RequestCredentials credentials;
  credentials.cookie = request.http.Header("Cookie");
  const auto who = api.accounts.Authenticate(credentials, api.clock.Wall());
  if (!who || who.value().user_id != account || who.value().proof != Proof::kSessionCookie) {
    return Error{ErrorCode::kForbidden, "somebody else is signed in now", "", "oidc_elsewhere"};
  }
  const core::Status added = api.accounts.AddIdentity(account, person, api.clock.Wall());
  if (added.ok()) {
    api.audit.Add(who.value(), "add_identity", who.value().owner_key(), person.issuer);
  }
  return added;
}

core::Result<HttpResponse> AnswerArrival(Api& api,
                                         const ApiRequest& request,
                                         const oidc::ProviderSettings& provider,
                                         const oidc::SignInFlow::Arrival& arrival) {
  const oidc::Person& person = arrival.person;
  const VouchedPerson vouched{
      person.issuer, person.subject, person.login, person.name, arrival.state.state};
  if (arrival.state.add_to != 0) {
    TRY_DONE(AddIdentity(api, request, arrival.state.add_to, vouched));
    return GoTo(arrival.state.next);
  }
  const std::string_view device = CookieValue(request.http.Header("Cookie"), kDeviceCookieName);
  SignInOutcome outcome = api.accounts.SignInByIdentity(
      vouched,
      {provider.make_accounts, provider.claim_class_list},
      {"", "", std::string(request.http.remote_address), std::string(device)},
      api.clock.Wall());
  if (!outcome.signed_in) return outcome.signed_in.error();
  if (outcome.note) {
    outcome.note->detail += " by " + provider.id;
    api.audit.AddBounded(*outcome.note);
  }
  HttpResponse response = GoTo(arrival.state.next);
  AddSignInCookies(request, outcome.signed_in.value(), response);
  return response;
}

core::Result<HttpResponse> FinishSignIn(Api& api, const ApiRequest& request) {
  TRY(auto provider, ProviderOf(api, request));
  const oidc::ProviderSettings& settings = provider->settings();
  const auto query = [&request](std::string_view name) {
    return std::string(request.http.Query(name).value_or(""));
  };
  oidc::SignInFlow::Callback callback;
  callback.provider = settings.id;
  callback.sealed = std::string(CookieValue(request.http.Header("Cookie"), LoginCookie(request)));
  callback.state = query("state");
  callback.code = query("code");
  callback.issuer = query("iss");
  callback.has_issuer = request.http.Query("iss").has_value();
  callback.error = query("error");
  const std::string network = AddressKey(request.http.remote_address);
  const core::Status patience = api.failed_callbacks.Try(network, api.clock.Wall());
  if (!patience.ok()) {
    Error busy = patience.error();
    busy.reason = "oidc_busy";
    return Refuse(api, request, settings.id, busy, /*adding=*/false);
  }
  const auto arrival = api.sign_in_flow.Finish(callback);
  core::Result<HttpResponse> answer = arrival.ok()
                                          ? AnswerArrival(api, request, settings, arrival.value())
                                          : core::Result<HttpResponse>(arrival.error());
  // Only what made the provider work counts against this network.
  if (answer.ok() || answer.error().reason != "oidc_failed") api.failed_callbacks.Forgive(network);
  const bool adding = arrival.ok() && arrival.value().state.add_to != 0;
  HttpResponse response =
      answer.ok() ? answer.value() : Refuse(api, request, settings.id, answer.error(), adding);
  SetCookie(request, LoginCookie(request), "", 0, response);
  return response;
}

core::Result<HttpResponse> ListIdentities(Api& api, const ApiRequest& request) {
  TRY(auto identities, api.accounts.Identities(request.who.user_id));
  json::array items;
  for (const auto& provider : api.sign_in_flow.providers()) {
    const oidc::ProviderSettings& settings = provider->settings();
    json::object item{{"provider", settings.id}, {"label", settings.label}, {"since", nullptr}};
    for (const LinkedIdentity& identity : identities) {
      if (identity.issuer == settings.issuer) item["since"] = Iso8601(identity.at);
    }
    items.push_back(std::move(item));
  }
  for (const LinkedIdentity& identity : identities) {
    const auto platform = lti::PlatformOf(identity.issuer);
    if (!platform) continue;
    const auto known = api.platforms.Get(*platform);
    items.push_back(json::object{{"provider", identity.issuer},
                                 {"label", known ? known.value().label : identity.issuer},
                                 {"since", Iso8601(identity.at)}});
  }
  return JsonResponse(json::object{{"items", std::move(items)}});
}

core::Result<HttpResponse> RemoveIdentity(Api& api, const ApiRequest& request) {
  std::string issuer = request.http.PathParameter("id");
  if (!lti::PlatformOf(issuer)) {
    TRY(const auto provider, ProviderOf(api, request));
    issuer = provider->settings().issuer;
  }
  TRY_DONE(api.accounts.RemoveIdentity(request.who.user_id, issuer));
  api.audit.Add(request.who, "remove_identity", request.who.owner_key(), issuer);
  return NoContent();
}

}  // namespace

std::string BaseUrl(const Api& api, const ApiRequest& request) {
  return !api.public_url.empty() ? api.public_url
                                 : (request.http.https ? "https://" : "http://") +
                                       std::string(request.http.Header("Host"));
}

HttpResponse GoTo(const std::string& location) {
  HttpResponse response;
  response.status = 303;
  response.content_type = {};
  response.headers.emplace_back("Location", location);
  return response;
}

std::span<const ApiRoute> ProvidersRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "auth/providers", kReadPublic, kOpen, ListProviders},
      ApiRoute{kGet, "auth/oidc/{id}/start", kReadPublic, kAnybody, StartSignIn, kNoBody, kOutside}
          .Takes("next"),
      ApiRoute{
          kGet, "auth/oidc/{id}/callback", kReadPublic, kAnybody, FinishSignIn, kNoBody, kOutside}
          .Takes("*"),
      {kPost,
       "auth/oidc/{id}/link",
       kManageOwnAccount,
       kRole,
       StartLink,
       kEmptyForSecret,
       kOutside},
      {kGet, "auth/identities", kManageOwnAccount, kRole, ListIdentities},
      {kDelete, "auth/identities/{id}", kManageOwnAccount, kRole, RemoveIdentity},
  });
  return kRoutes;
}

}  // namespace faultlab::server
