// courses/{id}/rosters: who is in a course, as the learning platforms say whose links lead there.
#include <boost/json.hpp>
#include <set>

#include "server/api/api.h"
#include "server/api/people/handlers.h"
#include "server/oidc/login_state.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

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

struct Taken {
  std::int64_t joined = 0, attended = 0, refused = 0;
};

core::Status Take(Api& api,
                  const ApiRequest& request,
                  const lti::Roster& roster,
                  const lti::Platform& platform,
                  const std::vector<lti::RosterStudent>& students,
                  Taken& taken) {
  for (const lti::RosterStudent& student : students) {
    const auto account =
        api.accounts.AdmitByIdentity({lti::NameOf(platform.id),
                                      student.subject,
                                      student.login,
                                      student.name,
                                      oidc::RandomText()},
                                     NewcomersOf(platform, student.subject, /*teaches=*/false),
                                     api.clock.Wall());
    if (!account && account.error().code != core::ErrorCode::kForbidden) return account.error();
    if (!account) {
      ++taken.refused;  // disabled, or of whoever runs the lab
      continue;
    }
    TRY(const bool joined,
        JoinByPlatform(api, request.who, roster.course, account.value(), platform.label));
    ++(joined ? taken.joined : taken.attended);
  }
  return core::Done{};
}

/// Asked at once: the teacher waits for the answer. Whoever is not in the platform's course any
/// more stays here.
core::Result<HttpResponse> TakeRosters(Api& api, const ApiRequest& request) {
  TRY(const auto course, TaughtCourse(api, request));
  TRY(const auto rosters, api.rosters.Of(course));
  if (rosters.empty()) return core::Refuse("no_roster");
  Taken taken;
  for (const lti::Roster& roster : rosters) {
    TRY(const auto platform, api.platforms.Get(roster.platform));
    TRY(const auto students, api.rosters.Read(platform, roster));
    TRY_DONE(Take(api, request, roster, platform, students, taken));
  }
  return JsonResponse(json::object{
      {"joined", taken.joined}, {"attended", taken.attended}, {"refused", taken.refused}});
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

core::Result<bool> JoinByPlatform(Api& api,
                                  const Principal& by,
                                  std::int64_t course,
                                  const Account& student,
                                  const std::string& label) {
  TRY(const auto whose, api.accounts.InCourse(student.id, course));
  if (whose != Ownership::kForeign) return false;
  TRY_DONE(api.accounts.Enrol(course, student.id, /*teaches=*/false));
  api.audit.Add(by, "enrol", "course:" + std::to_string(course), student.login + " by " + label);
  return true;
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
