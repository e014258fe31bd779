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

constexpr seconds kAssertionLives{300};
constexpr seconds kTokenMargin{60};
constexpr double kTokenMaxS = 3600.0;
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

/// 409: the platform has one of this second or a later one, maybe of less; 401 with a fresh token
/// and 500: this course or person is not graded. Other messages may be taken.
Attempt AnswerOf(int status) {
  if (status >= 200 && status < 300) return {};
  const bool later = status == 408 || status == 425 || status == 429 || status > 500;
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
                         course::TrialKeeper keep,
                         const Clock& clock)
    : keep_(std::move(keep)),
      platforms_(database),
      seats_(database),
      assignments_(database),
      trials_(database),
      key_(key),
      client_({.ca_file = reach.ca_file, .insecure_loopback = reach.insecure_loopback}),
      clock_(clock) {}

core::Result<bool> GradeSender::Gather(WallTime now) {
  TRY_DONE(keep_.Step(now));
  return seats_.Gather(now);
}

Attempt GradeSender::Send(const notify::Message& message) {
  const auto id = PlatformOf(message.channel);
  if (!id) return {Outcome::kNever, "nothing sends to " + message.channel};
  const std::int64_t exercise =
      json::parse(message.about).at("assignment").to_number<std::int64_t>();
  // Of two servers that send at once, the one that has read the older grade has the older time.
  const std::string stamp = notify::Stamp(clock_.Wall());
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
  WebRequest request;
  request.url = ScoresUrl(seat.value()->lineitem);
  request.body = json::serialize(json::object{{"userId", seat.value()->subject},
                                              {"scoreGiven", *lines.front().points},
                                              {"scoreMaximum", kPointsMax},
                                              {"activityProgress", "Completed"},
                                              {"gradingProgress", "FullyGraded"},
                                              {"timestamp", stamp}});
  // A token may have ended before its time.
  for (const bool last : {false, true}) {
    const auto token = TokenOf(platform.value());
    if (!token) return Failed(token.error());
    request.headers = {"Content-Type: application/vnd.ims.lis.v1.score+json",
                       "Accept: application/json",
                       "Authorization: Bearer " + token.value()};
    const auto answer = client_.Ask(request);
    if (!answer) {
      // A platform whose answer is too large has taken the grade.
      if (answer.error().code == core::ErrorCode::kTooLarge) return {};
      return {Outcome::kNotNow, answer.error().message};
    }
    if (answer.value().status != 401 || last) return AnswerOf(answer.value().status);
    Forget(*id);
  }
  return {};
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
                 "&client_assertion=" + FormEncode(assertion) +
                 "&scope=" + FormEncode(std::string(kScoreScope));
  TRY(const auto answer, client_.Ask(request));
  TRY(const auto object, oidc::ObjectOf(answer, "the platform's token address"));
  Token token{oidc::TextOf(object, "access_token"), {}};
  const bool plain = token.text.find_first_of("\r\n") == std::string::npos;
  if (token.text.empty() || !plain) {
    return core::Error{core::ErrorCode::kUnavailable, "the platform gave no token", ""};
  }
  const json::value* lives = object.if_contains("expires_in");
  const double given_s = lives != nullptr && lives->is_number() ? lives->to_number<double>() : 0.0;
  token.until =
      clock_.Monotonic() +
      std::max(seconds{0},
               seconds{static_cast<int>(std::clamp(given_s, 0.0, kTokenMaxS))} - kTokenMargin);
  const std::lock_guard lock(mutex_);
  tokens_[platform.id] = token;
  return token.text;
}

void GradeSender::Forget(std::int64_t platform) {
  const std::lock_guard lock(mutex_);
  tokens_.erase(platform);
}

}  // namespace faultlab::server::lti
