#include "server/lti/launch_flow.h"

#include <sodium.h>

#include <algorithm>
#include <boost/json.hpp>

#include "server/lti/exercise_code.h"
#include "server/lti/roles.h"
#include "server/oidc/claims.h"
#include "server/oidc/id_token.h"

namespace faultlab::server::lti {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;

constexpr std::string_view kClaim = "https://purl.imsglobal.org/spec/lti/claim/";
constexpr std::string_view kGradesClaim = "https://purl.imsglobal.org/spec/lti-ags/claim/endpoint";
constexpr std::string_view kRosterClaim =
    "https://purl.imsglobal.org/spec/lti-nrps/claim/namesroleservice";
constexpr std::size_t kTokenBytesMax = 32 << 10;
constexpr const char* kTicket = "lti-window";
constexpr const char* kConnect = "lti-connect";
constexpr const char* kResourceLink = "LtiResourceLinkRequest";
constexpr const char* kDeepLinking = "LtiDeepLinkingRequest";
constexpr std::string_view kDeepClaim = "https://purl.imsglobal.org/spec/lti-dl/claim/";
constexpr std::chrono::seconds kLinkLives{600};

Error Refusal(const char* reason, const std::string& message) {
  return {ErrorCode::kForbidden, message, "", reason};
}

const json::object* ObjectIn(const json::object& claims, std::string_view name) {
  const json::value* value = claims.if_contains(name);
  return value != nullptr ? value->if_object() : nullptr;
}

std::string Claim(const json::object& claims, std::string_view name) {
  return oidc::TextOf(claims, std::string(kClaim) + std::string(name));
}

bool IsRole(const json::object& claims, std::string_view role) {
  return HasRole(claims.if_contains(std::string(kClaim) + "roles"), role);
}

/// What the platform itself says of a login: Moodle, and platforms that know it from elsewhere. Who
/// makes a link writes its custom parameters, and an address of mail may be anybody's.
std::string LoginOf(const json::object& claims) {
  if (const json::object* more = ObjectIn(claims, std::string(kClaim) + "ext")) {
    if (std::string login = oidc::TextOf(*more, "user_username"); !login.empty()) return login;
  }
  const json::object* known = ObjectIn(claims, std::string(kClaim) + "lis");
  return known != nullptr ? oidc::TextOf(*known, "person_sourcedid") : std::string();
}

std::string LineitemOf(const json::object& claims) {
  const json::object* grades = ObjectIn(claims, kGradesClaim);
  const bool may =
      grades != nullptr &&
      Has(grades->if_contains("scope"), [](std::string_view each) { return each == kScoreScope; });
  return may ? oidc::TextOf(*grades, "lineitem") : std::string();
}

std::string RosterOf(const json::object& claims) {
  const json::object* people = ObjectIn(claims, kRosterClaim);
  return people != nullptr ? oidc::TextOf(*people, "context_memberships_url") : std::string();
}

core::Status CheckMessage(const json::object& claims, const Platform& platform) {
  if (Claim(claims, "version") != "1.3.0") {
    return Refusal("lti_message", "the message is of another version of LTI");
  }
  const std::string type = Claim(claims, "message_type");
  if (type != kResourceLink && type != kDeepLinking) {
    return Refusal("lti_message", "the message is a " + oidc::ForLog(type));
  }
  const std::string deployment = Claim(claims, "deployment_id");
  if (deployment.empty() || (!platform.deployment.empty() && deployment != platform.deployment)) {
    return Refusal("lti_failed", "the deployment " + oidc::ForLog(deployment) + " is not known");
  }
  return core::Done{};
}

core::Result<Launch::Choice> ChoiceOf(const json::object& claims) {
  const json::object* asked = ObjectIn(claims, std::string(kDeepClaim) + "deep_linking_settings");
  const bool links =
      asked != nullptr && Has(asked->if_contains("accept_types"),
                              [](std::string_view each) { return each == "ltiResourceLink"; });
  if (!links) return Refusal("lti_message", "the platform takes no link");
  return Launch::Choice{oidc::TextOf(*asked, "deep_link_return_url"),
                        oidc::TextOf(*asked, "data"),
                        Claim(claims, "deployment_id")};
}

bool Same(const std::string& a, const std::string& b) {
  return a.size() == b.size() && !a.empty() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace

std::string ValueOf(const Form& form, std::string_view name) {
  for (const auto& [key, value] : form) {
    if (key == name) return value;
  }
  return {};
}

LaunchFlow::LaunchFlow(Database& database,
                       std::string secret,
                       Reach reach,
                       const PlatformClient& client,
                       const Clock& clock)
    : platforms_(database),
      secret_(std::move(secret)),
      reach_(std::move(reach)),
      client_(client),
      clock_(clock),
      seal_("lti " + secret_) {}

std::shared_ptr<oidc::Provider> LaunchFlow::ProviderOf(const Platform& platform) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<oidc::Provider>& provider = providers_[NameOf(platform.id) + platform.keys_url];
  if (provider == nullptr) {
    oidc::ProviderSettings settings;
    settings.id = NameOf(platform.id);
    settings.label = platform.label;
    settings.issuer = platform.issuer;
    settings.client_id = platform.client_id;
    settings.ca_file = reach_.ca_file;
    settings.insecure_loopback = reach_.insecure_loopback;
    provider = std::make_shared<oidc::Provider>(std::move(settings), clock_);
  }
  return provider;
}

core::Result<LaunchFlow::Departure> LaunchFlow::Begin(const Form& asked,
                                                      const std::string& redirect_uri) {
  const auto platform = platforms_.Find(ValueOf(asked, "iss"), ValueOf(asked, "client_id"));
  if (!platform) {
    if (platform.error().code != ErrorCode::kNotFound) return platform.error();
    return Refusal("lti_unknown",
                   "the platform " + oidc::ForLog(ValueOf(asked, "iss")) + ", client " +
                       oidc::ForLog(ValueOf(asked, "client_id")) + ", is not registered");
  }
  const std::string hint = ValueOf(asked, "login_hint");
  if (hint.empty()) return Refusal("lti_failed", "the platform does not say whom (login_hint)");
  oidc::LoginState state;
  state.provider = NameOf(platform.value().id);
  state.state = oidc::RandomText();
  state.nonce = oidc::RandomText();
  state.began = clock_.Wall();
  const std::string& endpoint = platform.value().auth_url;
  std::string location = endpoint + (endpoint.find('?') == std::string::npos ? "?" : "&");
  location += "scope=openid&response_type=id_token&response_mode=form_post&prompt=none&client_id=" +
              FormEncode(platform.value().client_id) + "&redirect_uri=" + FormEncode(redirect_uri) +
              "&login_hint=" + FormEncode(hint) + "&state=" + state.state + "&nonce=" + state.nonce;
  const std::string message = ValueOf(asked, "lti_message_hint");
  if (!message.empty()) location += "&lti_message_hint=" + FormEncode(message);
  return Departure{std::move(location), seal_.Close(state)};
}

core::Result<Launch> LaunchFlow::Finish(const Form& posted, std::string_view sealed) {
  const auto state = seal_.Open(sealed, clock_.Wall());
  const auto id = state ? PlatformOf(state->provider) : std::nullopt;
  if (!id || !Same(state->state, ValueOf(posted, "state"))) {
    return Refusal("lti_elsewhere",
                   "this launch was not begun by this browser within the last 10 min, or it keeps "
                   "no cookies of pages in a frame");
  }
  const std::string token = ValueOf(posted, "id_token");
  if (token.empty() || token.size() > kTokenBytesMax) {
    return Refusal("lti_failed", "no ID token came: " + oidc::ForLog(ValueOf(posted, "error")));
  }
  TRY(const Platform platform, platforms_.Get(*id));
  oidc::Discovery keys;
  keys.jwks_uri = platform.keys_url;
  const auto claims = ProviderOf(platform)->ClaimsOf(keys, token);
  if (!claims) {
    const bool away = claims.error().reason == oidc::Provider::kAway;
    return Refusal(away ? "lti_away" : "lti_failed", claims.error().message);
  }
  const core::Status good = oidc::CheckIdToken(
      claims.value(), {platform.issuer, platform.client_id, state->nonce, "", clock_.Wall()});
  if (!good.ok()) return Refusal("lti_failed", good.error().message);
  TRY_DONE(CheckMessage(claims.value(), platform));

  Launch launch;
  launch.platform = platform;
  launch.subject = oidc::TextOf(claims.value(), "sub");
  launch.login = LoginOf(claims.value());
  launch.name = oidc::TextOf(claims.value(), "name");
  launch.state = state->state;
  launch.teaches = IsRole(claims.value(), "Instructor") || IsRole(claims.value(), "Administrator");
  if (!launch.teaches && !IsRole(claims.value(), "Learner")) {
    return Refusal("lti_role", "the message has neither a learner nor an instructor");
  }
  if (Claim(claims.value(), "message_type") == kDeepLinking) {
    TRY(launch.choice, ChoiceOf(claims.value()));
    TRY_DONE(client_.CheckUrl(launch.choice->return_url));
    if (!launch.teaches) return Refusal("lti_role", "a learner may not choose exercises");
    return launch;
  }
  if (const json::object* custom = ObjectIn(claims.value(), std::string(kClaim) + "custom")) {
    const std::string code = oidc::TextOf(*custom, "exercise");
    launch.exercise = ExerciseOf(code, secret_);
    if (!code.empty() && !launch.exercise) {
      return Refusal("lti_exercise", "the link's exercise is not of this lab");
    }
  }
  if (launch.exercise && !launch.teaches) launch.lineitem = LineitemOf(claims.value());
  launch.roster = RosterOf(claims.value());
  for (std::string* address : {&launch.lineitem, &launch.roster}) {
    if (!client_.CheckUrl(*address).ok()) address->clear();
  }
  return launch;
}

std::string LaunchFlow::TicketOf(const Launch& launch,
                                 const std::string& next,
                                 bool connects) const {
  oidc::LoginState ticket;
  ticket.provider = connects ? kConnect : kTicket;
  ticket.state = oidc::RandomText();
  ticket.nonce = launch.subject;
  ticket.verifier = NameOf(launch.platform.id);
  ticket.next = next;
  ticket.began = clock_.Wall();
  return seal_.Close(ticket);
}

core::Result<LaunchFlow::Ticket> LaunchFlow::Open(std::string_view sealed) const {
  const auto ticket = seal_.Open(sealed, clock_.Wall());
  if (!ticket || (ticket->provider != kTicket && ticket->provider != kConnect)) {
    return Refusal("lti_elsewhere", "the window's ticket is over");
  }
  return Ticket{
      ticket->verifier, ticket->nonce, ticket->state, ticket->next, ticket->provider == kConnect};
}

std::string LaunchFlow::LinkOf(const Launch& launch,
                               const ToolKey& key,
                               std::int64_t assignment,
                               const std::string& title,
                               const std::string& launch_url) const {
  const auto now =
      std::chrono::floor<std::chrono::seconds>(clock_.Wall()).time_since_epoch().count();
  const std::string lti(kClaim);
  const std::string deep(kDeepClaim);
  const json::object item{{"type", "ltiResourceLink"},
                          {"title", title},
                          {"url", launch_url},
                          {"custom", {{"exercise", CodeOf(assignment)}}},
                          {"lineItem", {{"scoreMaximum", 100}, {"label", title}}}};
  json::object claims{{"iss", launch.platform.client_id},
                      {"aud", launch.platform.issuer},
                      {"iat", now},
                      {"exp", now + kLinkLives.count()},
                      {"nonce", oidc::RandomText()},
                      {lti + "message_type", "LtiDeepLinkingResponse"},
                      {lti + "version", "1.3.0"},
                      {lti + "deployment_id", launch.choice->deployment},
                      {deep + "content_items", json::array{item}}};
  if (!launch.choice->data.empty()) claims[deep + "data"] = launch.choice->data;
  return key.Sign(claims);
}

std::string LaunchFlow::CodeOf(std::int64_t assignment) const {
  return ExerciseCode(assignment, secret_);
}

}  // namespace faultlab::server::lti
