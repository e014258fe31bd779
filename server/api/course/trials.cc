// trials: blind runs, their answers and grades.
#include <algorithm>
#include <boost/json.hpp>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "server/api/course/gradebook.h"
#include "server/api/course/handlers.h"
#include "server/course/answer.h"
#include "server/course/copies.h"
#include "server/course/statistics.h"
#include "server/json/json_reader.h"
#include "server/storage/not_yours.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using course::Assignment;
using course::Trial;

constexpr int kTrialsMax = 100'000;  ///< in a file of grades

/// The one place that decides what leaves the server of a trial: of its truth nothing, and of its
/// grade nothing, before both are released.
/// @param reader   who reads it: a hint is for those who paid for it alone
/// @param members  who share it, or nobody: it is of one person
/// @param teaches  for a teacher, who is told who brought its record while it was sealed
json::object TrialToJson(const Assignment& of,
                         const Trial& trial,
                         std::int64_t reader,
                         std::vector<std::int64_t> members = {},
                         bool teaches = false) {
  if (members.empty()) members.push_back(trial.account);
  json::object out{{"id", trial.id},
                   {"assignment", trial.assignment},
                   {"account", trial.account},
                   {"members", json::array(members.begin(), members.end())},
                   {"state", Name(trial.state)},
                   {"run", TextOrNull(trial.run)},
                   {"commitment", trial.commitment},
                   {"created_at", Iso8601(trial.created_at)},
                   {"answer_by", Iso8601(course::BlindTrials::AnswerBy(of, trial))},
                   {"ended_at", TimeOrNull(trial.ended_at)},
                   {"answered_at", TimeOrNull(trial.answered_at)},
                   {"released_at", TimeOrNull(trial.released_at)},
                   {"hints", json::parse(trial.hints)},
                   {"tried", trial.tried},
                   {"answer", nullptr},
                   {"grade", nullptr},
                   {"awarded", nullptr},
                   {"points", nullptr},
                   {"truth", nullptr},
                   {"nonce", nullptr},
                   {"void", TextOrNull(trial.why)}};
  if (teaches) {
    out["copies"] = ListOf(course::CopiesOf(trial), [](const course::Copy& copy) {
      return json::object{{"account", copy.account ? json::value(*copy.account) : nullptr},
                          {"recording", copy.recording},
                          {"at", Iso8601(copy.at)}};
    });
  }
  if (std::ranges::find(members, reader) == members.end() && !trial.released_at) {
    for (json::value& hint : out["hints"].as_array()) {
      hint.as_object().erase("at_s");
      hint.as_object().erase("components");
    }
  }
  if (!trial.answer.empty()) out["answer"] = json::parse(trial.answer);
  if (!trial.released_at) return out;
  if (!trial.grade.empty()) out["grade"] = json::parse(trial.grade);
  if (!trial.awarded.empty()) out["awarded"] = json::parse(trial.awarded);
  if (const auto points = course::PointsOf(trial)) out["points"] = *points;
  out["truth"] = trial.truth;
  out["nonce"] = trial.nonce;
  return out;
}

struct SeenTrial {
  Trial trial;
  Assignment assignment;
  std::vector<std::int64_t> members;
  bool own = false;
  bool teaches = false;
};

/// Who share this trial: one person, or a group.
core::Result<std::vector<std::int64_t>> MembersOf(Api& api, const Trial& trial) {
  TRY(const auto group, api.groups.Of(trial.assignment, trial.account));
  if (!group) return std::vector<std::int64_t>{trial.account};
  return group->members;
}

/// Of the path's {id}, if it is the caller's own or of a course that they teach or run.
core::Result<SeenTrial> TrialFor(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(auto trial, api.trials.Get(id));
  TRY(auto seen, AssignmentFor(api, request.who, trial.assignment));
  TRY(auto members, MembersOf(api, trial));
  const bool own = std::ranges::find(members, request.who.user_id) != members.end();
  if (!own && seen.whose == Ownership::kCourse) {
    return NotYours();
  }
  const Assignment& of = seen.assignment;
  TRY(auto now, api.blind_trials.Look(of, std::move(trial)));
  const bool teaches = seen.whose != Ownership::kCourse;
  return SeenTrial{std::move(now), of, std::move(members), own, teaches};
}

std::vector<std::int64_t> MembersIn(const std::map<std::int64_t, course::Group>& groups,
                                    const Trial& trial) {
  const auto group = groups.find(trial.account);
  if (group == groups.end()) return {trial.account};
  return group->second.members;
}

/// All that the caller may see of an assignment, as they are now.
core::Result<std::vector<Trial>> TrialsOf(Api& api,
                                          const ApiRequest& request,
                                          const SeenAssignment& seen,
                                          std::int64_t after,
                                          int limit) {
  const bool all = seen.whose != Ownership::kCourse;
  TRY(auto list,
      api.trials.Of(seen.assignment.id,
                    all ? std::nullopt : std::optional(request.who.user_id),
                    after,
                    limit));
  for (Trial& each : list) {
    TRY(each, api.blind_trials.Look(seen.assignment, std::move(each)));
  }
  return list;
}

core::Result<HttpResponse> ListTrials(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  TRY(const auto id, PathNumber(request));
  TRY(const auto seen, AssignmentFor(api, request.who, id));
  TRY(const auto list, TrialsOf(api, request, seen, page.after, page.limit));
  TRY(const auto groups, api.groups.All(seen.assignment.id));
  const bool teaches = seen.whose != Ownership::kCourse;
  const auto to_json = [&](const Trial& each) {
    return TrialToJson(
        seen.assignment, each, request.who.user_id, MembersIn(groups, each), teaches);
  };
  return page.Answer(list, to_json, &Trial::id);
}

core::Result<HttpResponse> StartTrial(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto seen, AssignmentFor(api, request.who, id));
  if (!seen.member()) {
    return core::Refuse("not_in_course");
  }
  ObjectReader in(request.body, "");
  const std::string rig = in.TextOr("rig", "", kNameBytesMax);
  const json::object* excitation = in.ObjectOrNull("excitation");
  if (auto error = in.Finish()) return *error;
  TRY(const auto group, api.groups.Of(id, request.who.user_id));
  const bool tries = seen.whose != Ownership::kCourse && !group;
  TRY(const auto begun,
      api.blind_trials.Start(request.who, seen.assignment, rig, excitation, tries));
  TRY(auto members, MembersOf(api, begun));
  return JsonResponse(TrialToJson(seen.assignment, begun, request.who.user_id, std::move(members)),
                      201);
}

core::Result<HttpResponse> GetTrial(Api& api, const ApiRequest& request) {
  TRY(const auto seen, TrialFor(api, request));
  return JsonResponse(
      TrialToJson(seen.assignment, seen.trial, request.who.user_id, seen.members, seen.teaches));
}

core::Result<HttpResponse> AnswerTrial(Api& api, const ApiRequest& request) {
  TRY(const auto seen, TrialFor(api, request));
  if (!seen.own) {
    return core::Refuse("trial_of_another");
  }
  TRY(const auto bench, api.benches.Find(seen.assignment.bench));
  TRY(const auto answer, course::ParseAnswer(request.body, *bench));
  TRY(const auto taken, api.blind_trials.TakeAnswer(seen.assignment, seen.trial, answer));
  return JsonResponse(
      TrialToJson(seen.assignment, taken, request.who.user_id, seen.members, seen.teaches));
}

core::Result<HttpResponse> TakeHint(Api& api, const ApiRequest& request) {
  TRY(const auto seen, TrialFor(api, request));
  if (!seen.own) {
    return core::Refuse("trial_of_another");
  }
  TRY(const auto number, PathNumber(request, "number"));
  TRY(const auto taken, api.blind_trials.TakeHint(seen.assignment, seen.trial, number));
  return JsonResponse(
      TrialToJson(seen.assignment, taken, request.who.user_id, seen.members, seen.teaches));
}

/// @param awarded  as it is kept; empty: the grade counts again
core::Result<HttpResponse> Awarded(Api& api,
                                   const ApiRequest& request,
                                   const std::string& awarded) {
  TRY(const auto seen, TrialFor(api, request));
  const Trial& trial = seen.trial;
  TRY(const auto whose, AssignmentFor(api, request.who, trial.assignment));
  TRY_DONE(Authorize(request.who, Operation::kManageCourse, whose.whose));
  if (!trial.released_at) {
    return core::Refuse("trial_not_released");
  }
  TRY_DONE(api.trials.Award(trial.id, awarded));
  api.audit.Add(request.who,
                "award_points",
                "trial:" + std::to_string(trial.id),
                awarded.empty() ? "the grade" : awarded);
  TRY(const auto now, api.trials.Get(trial.id));
  return JsonResponse(TrialToJson(seen.assignment, now, request.who.user_id, seen.members, true));
}

core::Result<HttpResponse> AwardPoints(Api& api, const ApiRequest& request) {
  constexpr double kPointsMax = 100.0;
  constexpr std::size_t kReasonBytesMax = 1000;
  ObjectReader in(request.body, "");
  const double points = in.Number("points", 0.0, kPointsMax);
  const std::string reason = in.Text("reason", kReasonBytesMax);
  if (reason.empty()) {
    in.Refuse("reason", "member_missing", {{"member", "reason"}});
  }
  if (auto error = in.Finish()) return *error;
  return Awarded(api,
                 request,
                 json::serialize(json::object{
                     {"points", points}, {"reason", reason}, {"by", request.who.name}}));
}

core::Result<HttpResponse> TakeAwardBack(Api& api, const ApiRequest& request) {
  return Awarded(api, request, "");
}

/// Without those by which a teacher tried it.
core::Result<std::vector<Trial>> TrialsOfClass(Api& api,
                                               const ApiRequest& request,
                                               const SeenAssignment& seen) {
  TRY(auto list, TrialsOf(api, request, seen, 0, kTrialsMax));
  std::erase_if(list, [](const Trial& each) { return each.tried; });
  return list;
}

core::Result<HttpResponse> GetStatistics(Api& api, const ApiRequest& request) {
  TRY(const auto seen, ManagedAssignment(api, request));
  TRY(const auto list, TrialsOfClass(api, request, seen));
  return JsonResponse(ToJson(course::StatisticsOf(list)));
}

/// One line for each trial and each person who shares it, in order.
std::string TrialLines(const Assignment& of,
                       const std::vector<Trial>& list,
                       const std::vector<Account>& members,
                       const std::map<std::int64_t, course::Group>& groups) {
  std::map<std::int64_t, const Account*> people;
  for (const Account& each : members) people[each.id] = &each;
  std::string text =
      "login,name,trial,state,started_at,answered_at,component,value,confidence,truth,points,"
      "awarded_because\r\n";
  for (const Trial& trial : list) {
    const json::object shown = TrialToJson(of, trial, 0);
    const json::object* answer = shown.at("answer").if_object();
    const auto of_answer = [&](const char* name) -> std::string {
      const json::value* value = answer != nullptr ? answer->if_contains(name) : nullptr;
      if (value == nullptr || value->is_null()) return "";
      if (value->is_string()) return std::string(value->get_string());
      return NumberText(value->to_number<double>());
    };
    std::string component = of_answer("component");
    if (answer != nullptr && component.empty()) component = "healthy";
    std::string truth, points;
    if (trial.released_at) {
      const json::value parsed = json::parse(trial.truth);
      const json::array& faults = parsed.at("faults").as_array();
      truth = faults.empty() ? "healthy"
                             : std::string(faults.front().at("component").as_string()) + " = " +
                                   NumberText(faults.front().at("value").to_number<double>());
    }
    if (const json::value& given = shown.at("points"); given.is_number()) {
      points = NumberText(given.to_number<double>());
    }
    std::string because;
    if (const json::object* awarded = shown.at("awarded").if_object()) {
      because = std::string(awarded->at("reason").as_string());
    }
    for (const std::int64_t member : MembersIn(groups, trial)) {
      const auto person = people.find(member);
      const bool known = person != people.end();
      for (const std::string& field :
           {known ? person->second->login : std::string(),
            known ? person->second->name : std::string(),
            std::to_string(trial.id),
            std::string(Name(trial.state)),
            Iso8601(trial.created_at),
            trial.answered_at ? Iso8601(*trial.answered_at) : std::string(),
            component,
            of_answer("value"),
            of_answer("confidence"),
            truth}) {
        text += CsvField(field) + ",";
      }
      text += points + "," + CsvField(because) + "\r\n";
    }
  }
  return text;
}

/// A line for each student, or for each trial.
core::Result<HttpResponse> ExportGrades(Api& api, const ApiRequest& request) {
  TRY(const auto each, QueryWord(request.http, "each", {"student", "trial"}));
  TRY(const auto whose,
      QueryWord(request.http, "for", {"excel", "excel_comma", "moodle", "canvas"}));
  TRY(const auto seen, ManagedAssignment(api, request));
  const Assignment& of = seen.assignment;
  TRY(const auto list, TrialsOfClass(api, request, seen));
  TRY(const auto members, api.accounts.Members(of.course));
  TRY(const auto groups, api.groups.All(of.id));
  HttpResponse response;
  if (each == "trial") {
    response.body = TrialLines(of, list, members, groups);
  } else {
    TRY(const auto rubric, course::ParseRubric(of.rubric_json));
    std::vector<course::Student> students;
    for (const Account& member : members) {
      if (member.role == Role::kStudent) students.push_back({member.id, member.login, member.name});
    }
    // Whoever has left the course, or is no student, and has attempts.
    std::set<std::int64_t> known;
    for (const course::Student& student : students) known.insert(student.account);
    for (const Trial& trial : list) {
      for (const std::int64_t member : MembersIn(groups, trial)) {
        if (!known.insert(member).second) continue;
        const auto person = api.accounts.Get(member);
        students.push_back({member,
                            person ? person.value().login : std::string(),
                            person ? person.value().name : std::string()});
      }
    }
    const auto share = [&](const Trial& trial) { return MembersIn(groups, trial); };
    response.body = GradebookText(course::GradebookOf(students, list, rubric.last_counts, share),
                                  of.name,
                                  whose == "excel"         ? GradebookFor::kExcel
                                  : whose == "excel_comma" ? GradebookFor::kExcelComma
                                  : whose == "moodle"      ? GradebookFor::kMoodle
                                  : whose == "canvas"      ? GradebookFor::kCanvas
                                                           : GradebookFor::kAnybody);
  }
  response.content_type = "text/csv; charset=utf-8";
  response.headers.emplace_back("Content-Disposition",
                                ContentDisposition("attachment", of.name + "-grades.csv"));
  return response;
}

}  // namespace

std::span<const ApiRoute> TrialsRoutes() {
  using namespace routing;
  // Whoever looks first at a class that is due releases all its trials: no quick work.
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "assignments/{id}/trials", kReadCourse, kRole, ListTrials, kNoBody, kHeavy}
          .Takes("cursor limit"),
      {kPost, "assignments/{id}/trials", kStartRun, kRole, StartTrial, kJson, kQuick, kBodysRig},
      ApiRoute{
          kGet, "assignments/{id}/grades.csv", kManageCourse, kRole, ExportGrades, kNoBody, kHeavy}
          .Takes("each for"),
      {kGet, "assignments/{id}/statistics", kManageCourse, kRole, GetStatistics, kNoBody, kHeavy},
      {kPut, "trials/{id}/points", kManageCourse, kRole, AwardPoints, kJson},
      {kDelete, "trials/{id}/points", kManageCourse, kRole, TakeAwardBack},
      {kGet, "trials/{id}", kReadCourse, kRole, GetTrial},
      {kPost, "trials/{id}/answer", kStartRun, kRole, AnswerTrial, kJson, kHeavy},
      {kPut, "trials/{id}/hints/{number}", kStartRun, kRole, TakeHint, kEmpty, kHeavy},
  });
  return kRoutes;
}

}  // namespace faultlab::server
