#include "server/lti/registration.h"

#include <algorithm>
#include <boost/json.hpp>

#include "core/types/utf8.h"
#include "server/lti/roles.h"
#include "server/oidc/claims.h"
#include "server/oidc/provider_documents.h"

namespace faultlab::server::lti {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using oidc::TextOf;

constexpr const char* kInvitation = "lti-register";
constexpr std::string_view kOfPlatform =
    "https://purl.imsglobal.org/spec/lti-platform-configuration";
constexpr std::string_view kOfTool = "https://purl.imsglobal.org/spec/lti-tool-configuration";
constexpr std::size_t kIssuerMax = 500;
constexpr std::size_t kTextMax = 200;  ///< as an admin may enter
constexpr std::size_t kLabelPartMax = 90;
constexpr int kCreated = 201;
constexpr int kOk = 200;

Error Failed(const std::string& message) {
  return {ErrorCode::kForbidden, message, "", "lti_register_failed"};
}

bool IsPlain(std::string_view text, std::size_t most) {
  return !text.empty() && text.size() <= most && core::IsUtf8(text) &&
         std::ranges::none_of(text, [](unsigned char c) { return c < ' ' || c == 0x7F; });
}

/// Without scheme and port.
std::string HostOf(const std::string& url) {
  const std::string origin(OriginOf(url));
  const std::size_t from = origin.find("://") + 3;
  const std::size_t port = origin.find(':', from);
  return origin.substr(from, port == std::string::npos ? port : port - from);
}

core::Result<json::object> ObjectOf(const core::Result<WebAnswer>& answer, const std::string& of) {
  if (!answer) return Failed(of + " did not answer: " + answer.error().message);
  WebAnswer plain = answer.value();
  if (plain.status == kCreated) plain.status = kOk;  // either is right for a registration
  auto object = oidc::ObjectOf(plain, of);
  if (!object) return Failed(object.error().message);
  return object;
}

/// A number for some platforms.
std::string DeploymentOf(const json::object& registered) {
  const json::value* tool = registered.if_contains(kOfTool);
  const json::object* known = tool != nullptr ? tool->if_object() : nullptr;
  const json::value* id = known != nullptr ? known->if_contains("deployment_id") : nullptr;
  if (id == nullptr) return {};
  if (id->is_string()) return TextOf(*known, "deployment_id");
  return id->is_number() ? json::serialize(*id) : std::string();
}

json::object MessageOf(const char* type, const std::string& launch) {
  json::object message{{"type", type}, {"target_link_uri", launch}, {"label", "faultlab"}};
  if (std::string_view(type) == "LtiDeepLinkingRequest") {
    message["placements"] = {"ContentArea", "assignment_selection", "link_selection"};
  }
  return message;
}

}  // namespace

ToolAddresses ToolAt(const std::string& base) {
  const std::string api = base + "/api/v1/lti/";
  return {api + "login", api + "launch", api + "keys"};
}

std::string Registration::Invite(std::int64_t admin) const {
  oidc::LoginState state;
  state.provider = kInvitation;
  state.state = oidc::RandomText();
  state.add_to = admin;
  state.began = clock_.Wall();
  return seal_.Close(state);
}

core::Result<Registration::Invitation> Registration::Open(std::string_view sealed) const {
  const auto state = seal_.Open(sealed, clock_.Wall(), kLives);
  if (!state || state->provider != kInvitation) {
    return Error{ErrorCode::kForbidden, "no address to register by", "", "lti_register_over"};
  }
  return Invitation{state->add_to, state->state};
}

core::Result<Registration::Offer> Registration::Read(const std::string& configuration_url) const {
  if (!client_.CheckUrl(configuration_url).ok()) {
    return Failed("the address of the platform's configuration is none that may be asked");
  }
  TRY(const json::object said,
      ObjectOf(client_.Ask({configuration_url, {"Accept: application/json"}}),
               "the platform's configuration"));
  Offer offer;
  Platform& platform = offer.platform;
  platform.issuer = TextOf(said, "issuer");
  platform.auth_url = TextOf(said, "authorization_endpoint");
  platform.token_url = TextOf(said, "token_endpoint");
  platform.keys_url = TextOf(said, "jwks_uri");
  offer.endpoint = TextOf(said, "registration_endpoint");
  if (!client_.CheckUrl(platform.issuer).ok() || platform.issuer.size() > kIssuerMax ||
      HostOf(platform.issuer) != HostOf(configuration_url)) {
    return Failed("the configuration is of " + oidc::ForLog(platform.issuer) +
                  ", and lies at another host");
  }
  for (const std::string& url :
       {platform.auth_url, platform.token_url, platform.keys_url, offer.endpoint}) {
    if (client_.CheckUrl(url).ok()) continue;
    return Failed("the configuration names an address that may not be asked: '" +
                  oidc::ForLog(url) + "'");
  }
  std::string product;
  if (const json::value* of = said.if_contains(kOfPlatform); of != nullptr && of->is_object()) {
    product = TextOf(of->get_object(), "product_family_code");
  }
  if (!IsPlain(product, kLabelPartMax)) product = "LTI";
  platform.label = product + " " + HostOf(platform.issuer).substr(0, kLabelPartMax);
  const json::value* supported = said.if_contains("scopes_supported");
  for (const std::string_view scope : {kScoreScope, kRosterScope}) {
    const bool may = supported == nullptr ||
                     Has(supported, [&](std::string_view each) { return each == scope; });
    if (may) offer.scopes += (offer.scopes.empty() ? "" : " ") + std::string(scope);
  }
  return offer;
}

core::Result<Platform> Registration::Enter(const Offer& offer,
                                           const std::string& token,
                                           const ToolAddresses& tool) const {
  const json::object about{{"domain", OriginOf(tool.launch).substr(tool.launch.find("://") + 3)},
                           {"target_link_uri", tool.launch},
                           {"claims", {"iss", "sub", "name", "given_name", "family_name"}},
                           {"messages",
                            {MessageOf("LtiResourceLinkRequest", tool.launch),
                             MessageOf("LtiDeepLinkingRequest", tool.launch)}}};
  WebRequest request{offer.endpoint,
                     {"Content-Type: application/json", "Accept: application/json"}};
  const bool plain = token.find_first_of("\r\n") == std::string::npos;
  if (!token.empty() && plain) request.headers.push_back("Authorization: Bearer " + token);
  request.body = json::serialize(json::object{{"application_type", "web"},
                                              {"response_types", {"id_token"}},
                                              {"grant_types", {"implicit", "client_credentials"}},
                                              {"initiate_login_uri", tool.login},
                                              {"redirect_uris", {tool.launch}},
                                              {"client_name", "faultlab"},
                                              {"jwks_uri", tool.keys},
                                              {"token_endpoint_auth_method", "private_key_jwt"},
                                              {"scope", offer.scopes},
                                              {kOfTool, about}});
  TRY(const json::object registered, ObjectOf(client_.Ask(request), "the platform's registration"));
  Platform platform = offer.platform;
  platform.client_id = TextOf(registered, "client_id");
  platform.deployment = DeploymentOf(registered);
  platform.created = clock_.Wall();
  const bool deployment = platform.deployment.empty() || IsPlain(platform.deployment, kTextMax);
  if (!IsPlain(platform.client_id, kTextMax) || !deployment) {
    return Failed("the platform gave no client ID, or one that is too long");
  }
  return platform;
}

}  // namespace faultlab::server::lti
