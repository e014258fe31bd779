#include "server/lti/grade_sender.h"

#include <boost/json.hpp>
#include <utility>

#include "server/course/grade.h"
#include "server/course/gradebook.h"
#include "server/oidc/claims.h"
#include "server/oidc/provider_documents.h"
#include "server/storage/ids.h"

namespace faultlab::server::lti {
namespace {

namespace json = boost::json;
using notify::Attempt;
using Outcome = Attempt::Outcome;
using std::chrono::seconds;

constexpr const char* kScope = "https://purl.imsglobal.org/spec/lti-ags/scope/score";
constexpr seconds kAssertionLives{300};
constexpr seconds kTokenMargin{60};
constexpr int kTrialsMax = 1000;
constexpr double kPointsMax = 100.0;

std::int64_t SecondsOf(WallTime time) {
  return std::chrono::floor<seconds>(time).time_since_epoch().count();
}

/// Moodle's lineitems end in a query: "../lineitem?type_id=3".
std::string ScoresUrl(const std::string& lineitem) {
  const std::size_t query = std::min(lineitem.find('?'), lineitem.size());
  return lineitem.substr(0, query) + "/scores" + lineitem.substr(query);
}

Attempt AnswerOf(int status) {
  // 409: it has had a newer one.
  if ((status >= 200 && status < 300) || status == 409) return {};
  const bool later =
      status == 401 || status == 408 || status == 425 || status == 429 || status >= 500;
  return {later ? Outcome::kNotNow : Outcome::kRefused,
          "the platform answered " + std::to_string(status)};
}

Attempt Failed(const core::Error& error) {
  const bool gone = error.code == core::ErrorCode::kNotFound;
  return {gone ? Outcome::kNever : Outcome::kNotNow, error.message};
}

}  // namespace

GradeSender::GradeSender(Database& database,
                         const ToolKey& key,
                         const Reach& reach,
                         const Clock& clock)
    : platforms_(database),
      seats_(database),
      assignments_(database),
      trials_(database),
      key_(key),
      client_({.ca_file = reach.ca_file, .insecure_loopback = reach.insecure_loopback}),
      clock_(clock) {}

Attempt GradeSender::Send(const notify::Message& message) {
  const auto id = PlatformOf(message.channel);
  if (!id) return {Outcome::kNever, "nothing sends to " + message.channel};
  const std::int64_t exercise =
      json::parse(message.about).at("assignment").to_number<std::int64_t>();
  const auto platform = platforms_.Get(*id);
  if (!platform) return Failed(platform.error());
  const auto seat = seats_.Find(*id, exercise, message.account);
  if (!seat) return Failed(seat.error());
  if (!seat.value()) return {Outcome::kNever, "the student has no place there any more"};
  const auto assignment = assignments_.Get(exercise);
  if (!assignment) return Failed(assignment.error());
  const auto rubric = course::ParseRubric(assignment.value().rubric_json);
  if (!rubric) return Failed(rubric.error());
  const auto trials = trials_.Of(exercise, message.account, 0, kTrialsMax);
  if (!trials) return Failed(trials.error());
  const course::Student student{message.account, "", ""};
  const auto lines = course::GradebookOf(
      {&student, 1}, trials.value(), rubric.value().last_counts, [&](const course::Trial&) {
        return std::vector<std::int64_t>{message.account};
      });
  if (!lines.front().points) return {};  // nothing to say yet
  const auto token = TokenOf(platform.value());
  if (!token) return Failed(token.error());

  WebRequest request;
  request.url = ScoresUrl(seat.value()->lineitem);
  request.headers = {"Content-Type: application/vnd.ims.lis.v1.score+json",
                     "Accept: application/json",
                     "Authorization: Bearer " + token.value()};
  request.body = json::serialize(json::object{{"userId", seat.value()->subject},
                                              {"scoreGiven", *lines.front().points},
                                              {"scoreMaximum", kPointsMax},
                                              {"activityProgress", "Completed"},
                                              {"gradingProgress", "FullyGraded"},
                                              {"timestamp", notify::Stamp(clock_.Wall())}});
  const auto answer = client_.Ask(request);
  if (!answer) {
    // A platform whose answer is too large has taken the grade.
    if (answer.error().code == core::ErrorCode::kTooLarge) return {};
    return {Outcome::kNotNow, answer.error().message};
  }
  if (answer.value().status == 401) Forget(*id);
  return AnswerOf(answer.value().status);
}

core::Status GradeSender::CheckToken(const Platform& platform) {
  Forget(platform.id);
  TRY(const auto token, TokenOf(platform));
  return token.empty() ? core::Refuse("platform_silent") : core::Status(core::Done{});
}

core::Result<std::string> GradeSender::TokenOf(const Platform& platform) {
  {
    const std::lock_guard lock(mutex_);
    const auto known = tokens_.find(platform.id);
    if (known != tokens_.end() && clock_.Monotonic() < known->second.until) {
      return known->second.text;
    }
  }
  const WallTime now = clock_.Wall();
  const std::string assertion = key_.Sign({{"iss", platform.client_id},
                                           {"sub", platform.client_id},
                                           {"aud", platform.token_url},
                                           {"iat", SecondsOf(now)},
                                           {"exp", SecondsOf(now + kAssertionLives)},
                                           {"jti", NewId("jti")}});
  WebRequest request;
  request.url = platform.token_url;
  request.headers = {"Accept: application/json"};
  request.body = "grant_type=client_credentials&client_assertion_type=" +
                 FormEncode("urn:ietf:params:oauth:client-assertion-type:jwt-bearer") +
                 "&client_assertion=" + FormEncode(assertion) + "&scope=" + FormEncode(kScope);
  TRY(const auto answer, client_.Ask(request));
  TRY(const auto object, oidc::ObjectOf(answer, "the platform's token address"));
  Token token{oidc::TextOf(object, "access_token"), {}};
  const bool plain = token.text.find_first_of("\r\n") == std::string::npos;
  if (token.text.empty() || !plain) {
    return core::Error{core::ErrorCode::kUnavailable, "the platform gave no token", ""};
  }
  const json::value* lives = object.if_contains("expires_in");
  const seconds given{lives != nullptr && lives->is_number() ? lives->to_number<std::int64_t>()
                                                             : 0};
  token.until = clock_.Monotonic() + std::clamp(given - kTokenMargin, seconds{0}, seconds{3600});
  const std::lock_guard lock(mutex_);
  tokens_[platform.id] = token;
  return token.text;
}

void GradeSender::Forget(std::int64_t platform) {
  const std::lock_guard lock(mutex_);
  tokens_.erase(platform);
}

}  // namespace faultlab::server::lti
