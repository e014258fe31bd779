// assignments: what a course's students are to diagnose, and until when.
#include <boost/json.hpp>
#include <map>
#include <utility>

#include "server/api/course/assignment_request.h"
#include "server/api/course/handlers.h"
#include "server/api/people/handlers.h"
#include "server/auth/secrets.h"
#include "server/course/grade.h"
#include "server/diagnosis_json/isolability_json.h"
#include "server/json/json_reader.h"
#include "server/storage/not_yours.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using course::Assignment;

/// How many students of the course have begun, and have answered.
core::Result<json::object> CourseProgress(Api& api, const Assignment& of) {
  TRY(const auto members, api.accounts.Members(of.course));
  TRY(const auto begun, api.trials.Begun(of.id));
  TRY(const auto groups, api.groups.All(of.id));
  std::map<std::int64_t, bool> each = begun;
  for (const auto& [account, answered] : begun) {
    const auto group = groups.find(account);
    if (group == groups.end()) continue;
    for (const std::int64_t mate : group->second.members) each[mate] = each[mate] || answered;
  }
  TRY(const auto stale, api.trials.Stale(of));
  json::object out{{"students", 0}, {"begun", 0}, {"answered", 0}, {"to_grade", stale}};
  for (const Account& member : members) {
    if (member.role != Role::kStudent) continue;
    out["students"] = out["students"].as_int64() + 1;
    const auto found = each.find(member.id);
    if (found == each.end()) continue;
    out["begun"] = out["begun"].as_int64() + 1;
    if (found->second) out["answered"] = out["answered"].as_int64() + 1;
  }
  return out;
}

json::object AssignmentToJson(Api& api, const ApiRequest& request, const SeenAssignment& seen) {
  const Principal& who = request.who;
  const Assignment& of = seen.assignment;
  const auto bench = api.benches.Find(of.bench);
  json::object out{{"id", of.id},
                   {"course", of.course},
                   {"name", of.name},
                   {"bench", bench.ok() ? bench.value()->id : of.bench},
                   {"fault_set", nullptr},
                   {"pool", nullptr},
                   {"plan", json::parse(of.plan_json)},
                   {"rubric", json::parse(of.rubric_json)},
                   {"opens", Iso8601(of.opens)},
                   {"due", Iso8601(of.due)},
                   {"your_due", Iso8601(of.DueFor(who.user_id))},
                   {"your_close", Iso8601(course::BlindTrials::ClosesFor(of, who.user_id))},
                   {"version", of.version},
                   {"extensions", nullptr},
                   {"exercise_code", nullptr},
                   {"launch_url", nullptr},
                   {"progress", nullptr},
                   {"attempts", of.attempts},
                   {"group_max", of.group_max},
                   {"group", nullptr},
                   {"on", of.on_bench ? "bench" : "simulator"},
                   {"reveal", of.reveal_at_once ? "answer" : "due"},
                   {"teaches", seen.whose != Ownership::kCourse},
                   {"created_at", Iso8601(of.created_at)}};
  if (of.group_max > 1) {
    const auto group = api.groups.Of(of.id, who.user_id);
    if (group && group.value()) out["group"] = ToJson(api, *group.value());
  }
  // What faults may come is the teacher's to know.
  if (seen.whose == Ownership::kCourse) return out;
  out["fault_set"] = of.fault_set;
  out["exercise_code"] = api.launches.CodeOf(of.id);
  out["launch_url"] = lti::ToolAt(BaseUrl(api, request)).launch;
  out["pool"] = json::parse(of.pool_json);
  out["extensions"] = ListOf(of.extensions, [](const auto& extension) {
    return json::object{{"account", extension.first}, {"due", Iso8601(extension.second)}};
  });
  if (auto progress = CourseProgress(api, of)) out["progress"] = std::move(progress).value();
  return out;
}

HttpResponse AssignmentResponse(Api& api, const ApiRequest& request, const SeenAssignment& seen) {
  return Versioned(JsonResponse(AssignmentToJson(api, request, seen)), seen.assignment.version);
}

core::Result<HttpResponse> ListAssignments(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  const bool all = Authorize(request.who, Operation::kReadCourse, Ownership::kForeign).ok();
  const auto mine = all ? std::nullopt : std::optional(request.who.user_id);
  TRY(auto list, api.assignments.List(mine, page.after, page.limit));
  json::array items;
  std::int64_t last = 0;
  for (Assignment& each : list) {
    SeenAssignment seen;
    TRY(const auto whose, api.accounts.InCourse(request.who.user_id, each.course));
    last = each.id;
    seen.whose = whose;
    seen.assignment = std::move(each);
    items.push_back(AssignmentToJson(api, request, seen));
  }
  return page.Answer(std::move(items), last);
}

core::Result<HttpResponse> CreateAssignment(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  Assignment assignment;
  assignment.author = request.who.user_id;
  assignment.created_at = api.clock.Wall();
  assignment.opens = assignment.created_at;
  assignment.course = in.Integer("course", 1, INT64_MAX);
  assignment.fault_set = in.Integer("fault_set", 1, INT64_MAX);
  (void)in.Text("name", kNameBytesMax);
  (void)in.Text("due", kNameBytesMax);
  assignment.on_bench = in.WordOr("on", "simulator", {"simulator", "bench"}) == "bench";
  assignment.group_max = static_cast<int>(in.IntegerOr("group_max", 1, 1, course::kGroupMax));
  const core::Status terms = ReadTerms(in, assignment);
  const json::object* rubric = in.ObjectOrNull("rubric");
  const json::object* plan = in.ObjectOrNull("plan");
  if (auto error = in.Finish()) return *error;
  if (!terms.ok()) return terms.error();
  TRY_DONE(CheckTimes(assignment, api.clock.Wall()));
  TRY(const auto graded, course::ParseRubric(rubric != nullptr ? *rubric : json::object{}));
  assignment.rubric_json = json::serialize(ToJson(graded));
  TRY(const auto whose, api.accounts.InCourse(request.who.user_id, assignment.course));
  if (!Authorize(request.who, Operation::kManageCourse, whose).ok()) {
    return core::Refuse("no_course", "/course");
  }
  TRY_DONE(TakeSet(api, request, plan, assignment));
  assignment.secret = NewSecret("");
  TRY(auto made, api.assignments.Create(std::move(assignment)));
  TRY_DONE(api.fault_sets.MarkUsed(made.fault_set));
  api.audit.Add(
      request.who, "create_assignment", "assignment:" + std::to_string(made.id), made.name);
  return JsonResponse(AssignmentToJson(api, request, {std::move(made), Ownership::kOwn}), 201);
}

core::Result<HttpResponse> PreviewAssignment(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string bench = in.Text("bench", kNameBytesMax);
  const json::object* pool = in.ObjectOrNull("pool");
  const json::object* plan = in.ObjectOrNull("plan");
  const json::object* rubric = in.ObjectOrNull("rubric");
  if (auto error = in.Finish()) return *error;
  TRY(const auto graded, course::ParseRubric(rubric != nullptr ? *rubric : json::object{}));
  TRY(const auto judged,
      JudgePool(api, request, bench, pool != nullptr ? *pool : json::object{}, plan, graded));
  return JsonResponse(json::object{{"isolability", ToJson(judged.isolability)},
                                   {"expected", ToJson(judged.expected)}});
}

core::Result<HttpResponse> GetAssignment(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto seen, AssignmentFor(api, request.who, id));
  return AssignmentResponse(api, request, seen);
}

void Audit(Api& api,
           const ApiRequest& request,
           const std::string& verb,
           const Assignment& of,
           const std::string& more = {}) {
  api.audit.Add(request.who, verb, "assignment:" + std::to_string(of.id), of.name + more);
}

core::Result<HttpResponse> Extended(Api& api,
                                    const ApiRequest& request,
                                    const std::optional<WallTime>& due) {
  TRY(auto seen, ManagedAssignment(api, request));
  TRY(const auto account, PathNumber(request, "user"));
  const std::int64_t id = seen.assignment.id;
  TRY(const auto whose, api.accounts.InCourse(account, seen.assignment.course));
  if (whose == Ownership::kForeign) return NotYours();
  if (due && *due <= seen.assignment.due) return core::Refuse("extension_not_later", "/due");
  TRY_DONE(api.assignments.Extend(id, account, due));
  Audit(api,
        request,
        "extend_assignment",
        seen.assignment,
        ": user:" + std::to_string(account) + (due ? " " + Iso8601(*due) : ""));
  TRY(auto now, AssignmentFor(api, request.who, id));
  return AssignmentResponse(api, request, now);
}

core::Result<HttpResponse> ChangeAssignment(Api& api, const ApiRequest& request) {
  TRY(const auto version, RequiredVersion(request));
  TRY(auto seen, ManagedAssignment(api, request));
  ObjectReader in(request.body, "");
  const core::Status terms = ReadTerms(in, seen.assignment);
  const json::object* rubric = in.ObjectOrNull("rubric");
  if (auto error = in.Finish()) return *error;
  if (!terms.ok()) return terms.error();
  if (rubric != nullptr) {
    TRY(const auto graded, course::ParseRubric(*rubric));
    seen.assignment.rubric_json = json::serialize(ToJson(graded));
  }
  // It may end at once.
  TRY_DONE(CheckTimes(seen.assignment, WallTime{}));
  TRY(auto changed, api.assignments.Change(seen.assignment, version));
  std::string members;
  for (const auto& [name, value] : request.body) {
    members += (members.empty() ? ": " : ", ") + std::string(name);
  }
  Audit(api, request, "change_assignment", changed, members);
  seen.assignment = std::move(changed);
  return AssignmentResponse(api, request, seen);
}

core::Result<HttpResponse> ExtendAssignment(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  (void)in.Text("due", kNameBytesMax);
  WallTime due{};
  const core::Status read = ReadTime(in, "due", due);
  if (auto error = in.Finish()) return *error;
  if (!read.ok()) return read.error();
  return Extended(api, request, due);
}

core::Result<HttpResponse> EndExtension(Api& api, const ApiRequest& request) {
  return Extended(api, request, std::nullopt);
}

core::Result<HttpResponse> DeleteAssignment(Api& api, const ApiRequest& request) {
  TRY(const auto seen, ManagedAssignment(api, request));
  TRY_DONE(api.assignments.Delete(seen.assignment.id));
  Audit(api, request, "delete_assignment", seen.assignment);
  return NoContent();
}

}  // namespace

core::Result<SeenAssignment> AssignmentFor(Api& api, const Principal& who, std::int64_t id) {
  TRY(auto assignment, api.assignments.Get(id));
  SeenAssignment seen;
  TRY(const auto whose, api.accounts.InCourse(who.user_id, assignment.course));
  TRY_DONE(Authorize(who, Operation::kReadCourse, whose));
  seen.assignment = std::move(assignment);
  seen.whose = whose;
  return seen;
}

core::Result<SeenAssignment> ManagedAssignment(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(auto seen, AssignmentFor(api, request.who, id));
  TRY_DONE(Authorize(request.who, Operation::kManageCourse, seen.whose));
  return seen;
}

std::span<const ApiRoute> AssignmentsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "assignments", kReadCourse, kRole, ListAssignments}.Takes("cursor limit"),
      {kPost, "assignments", kManageCourse, kRole, CreateAssignment, kJson, kHeavy},
      {kPost, "assignments/preview", kManageCourse, kRole, PreviewAssignment, kJson, kHeavy},
      {kGet, "assignments/{id}", kReadCourse, kRole, GetAssignment},
      {kPatch, "assignments/{id}", kManageCourse, kRole, ChangeAssignment, kJson},
      {kPut, "assignments/{id}/extensions/{user}", kManageCourse, kRole, ExtendAssignment, kJson},
      {kDelete, "assignments/{id}/extensions/{user}", kManageCourse, kRole, EndExtension},
      {kDelete, "assignments/{id}", kManageCourse, kRole, DeleteAssignment},
  });
  return kRoutes;
}

}  // namespace faultlab::server
