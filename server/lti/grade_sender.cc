#include "server/lti/grade_sender.h"

#include <boost/json.hpp>
#include <utility>

#include "server/course/grade.h"
#include "server/course/gradebook.h"

namespace faultlab::server::lti {
namespace {

namespace json = boost::json;
using notify::Attempt;
using Outcome = Attempt::Outcome;

constexpr int kTrialsMax = 1000;
constexpr double kPointsMax = 100.0;

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
                         PlatformClient& client,
                         course::TrialKeeper keep,
                         const Clock& clock)
    : keep_(std::move(keep)),
      platforms_(database),
      seats_(database),
      assignments_(database),
      trials_(database),
      client_(client),
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
  request.headers = {"Content-Type: application/vnd.ims.lis.v1.score+json",
                     "Accept: application/json"};
  const auto answer = client_.AskAs(platform.value(), kScoreScope, request);
  if (answer) return AnswerOf(answer.value().status);
  // A platform whose answer is too large has taken the grade.
  if (answer.error().code == core::ErrorCode::kTooLarge) return {};
  return {Outcome::kNotNow, answer.error().message};
}

}  // namespace faultlab::server::lti
