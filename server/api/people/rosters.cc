// courses/{id}/rosters: who is in a course, as the learning platforms say whose links lead there.
#include <boost/json.hpp>
#include <set>

#include "server/api/api.h"
#include "server/api/people/handlers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::chrono::seconds kPatience{60};  ///< with all platforms together

core::Result<HttpResponse> ListRosters(Api& api, const ApiRequest& request) {
  TRY(const auto course, TaughtCourse(api, request));
  TRY(const auto rosters, api.rosters.Of(course));
  json::array items;
  std::set<std::int64_t> shown;
  for (const lti::Roster& roster : rosters) {
    if (!shown.insert(roster.platform).second) continue;
    const auto platform = api.platforms.Get(roster.platform);
    if (platform)
      items.push_back({{"platform", roster.platform}, {"label", platform.value().label}});
  }
  return ListAnswer(std::move(items));
}

/// What does not exist on the platform any more is forgotten.
bool IsGone(const core::Error& error) {
  return error.code == core::ErrorCode::kNotFound;
}

/// Asked at once: the teacher waits for the answer. Whoever is not in the platform's course any
/// more stays here.
core::Result<HttpResponse> TakeRosters(Api& api, const ApiRequest& request) {
  TRY(const auto course, TaughtCourse(api, request));
  TRY(const auto rosters, api.rosters.Of(course));
  const MonotonicTime until = api.clock.Monotonic() + kPatience;
  std::vector<RosterPerson> people;
  bool any = false;
  for (const lti::Roster& roster : rosters) {
    const auto platform = api.platforms.Get(roster.platform);
    auto students = platform ? api.rosters.Read(platform.value(), roster, until)
                             : core::Result<std::vector<lti::RosterStudent>>(platform.error());
    if (!students && IsGone(students.error())) {
      TRY_DONE(api.rosters.Forget(roster));
      continue;
    }
    if (!students) return students.error();
    any = true;
    for (lti::RosterStudent& student : students.value()) {
      const NewcomerRules rules = NewcomersOf(platform.value(), student.subject, /*teaches=*/false);
      people.push_back({{lti::NameOf(roster.platform),
                         std::move(student.subject),
                         std::move(student.login),
                         std::move(student.name),
                         ""},
                        rules});
    }
  }
  if (!any) return core::Refuse("no_roster");
  TRY(const auto enrolment,
      api.accounts.EnrolRoster(request.who, course, people, api.clock.Wall()));
  return JsonResponse(json::object{
      {"joined", enrolment.enrolled.size()},
      {"invited", enrolment.invited.size() + static_cast<std::size_t>(enrolment.invited_already)},
      {"attended", enrolment.members_already},
      {"refused", enrolment.refused}});
}

}  // namespace

NewcomerRules NewcomersOf(const lti::Platform& platform, const std::string& subject, bool teaches) {
  NewcomerRules rules;
  rules.make_accounts = !teaches || platform.makes_teachers;
  rules.claim_class_list = platform.claims_class_lists && !teaches;
  rules.staff = false;
  rules.role = teaches ? Role::kInstructor : Role::kStudent;
  // Logins of people who have no login, or that of somebody else.
  rules.other_login = "lti" + std::to_string(platform.id) + "-" +
                      HashSecret(lti::NameOf(platform.id) + subject).substr(0, 10);
  return rules;
}

std::span<const ApiRoute> RostersRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "courses/{id}/rosters", kReadCourse, kRole, ListRosters},
      {kPost, "courses/{id}/rosters", kReadCourse, kRole, TakeRosters, kEmpty, kOutside},
  });
  return kRoutes;
}

}  // namespace faultlab::server
