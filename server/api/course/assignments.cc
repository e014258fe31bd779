// assignments: what a course's students are to diagnose, and until when.
#include <boost/json.hpp>
#include <map>
#include <utility>

#include "server/api/course/assignment_request.h"
#include "server/api/course/handlers.h"
#include "server/auth/secrets.h"
#include "server/course/grade.h"
#include "server/diagnosis_json/isolability_json.h"
#include "server/json/json_reader.h"
#include "server/storage/not_yours.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using core::Error;
using core::ErrorCode;
using course::Assignment;

/// How many students of the course have begun, and have answered.
core::Result<json::object> CourseProgress(CourseApi& api, const Assignment& of) {
  const auto members = api.accounts.Members(of.course);
  if (!members) return members.error();
  const auto begun = api.trials.Begun(of.id);
  if (!begun) return begun.error();
  const auto groups = api.groups.All(of.id);
  if (!groups) return groups.error();
  std::map<std::int64_t, bool> each = begun.value();
  for (const auto& [account, answered] : begun.value()) {
    const auto group = groups.value().find(account);
    if (group == groups.value().end()) continue;
    for (const std::int64_t mate : group->second.members) each[mate] = each[mate] || answered;
  }
  json::object out{{"students", 0}, {"begun", 0}, {"answered", 0}};
  for (const Account& member : members.value()) {
    if (member.role != Role::kStudent) continue;
    out["students"] = out["students"].as_int64() + 1;
    const auto found = each.find(member.id);
    if (found == each.end()) continue;
    out["begun"] = out["begun"].as_int64() + 1;
    if (found->second) out["answered"] = out["answered"].as_int64() + 1;
  }
  return out;
}

json::object AssignmentToJson(CourseApi& api, const Principal& who, const SeenAssignment& seen) {
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
  out["pool"] = json::parse(of.pool_json);
  json::array extensions;
  for (const auto& [account, due] : of.extensions) {
    extensions.push_back(json::object{{"account", account}, {"due", Iso8601(due)}});
  }
  out["extensions"] = std::move(extensions);
  if (auto progress = CourseProgress(api, of)) out["progress"] = std::move(progress).value();
  return out;
}

HttpResponse AssignmentResponse(CourseApi& api,
                                const ApiRequest& request,
                                const SeenAssignment& seen,
                                int status = 200) {
  HttpResponse response = JsonResponse(AssignmentToJson(api, request.who, seen), status);
  response.headers.emplace_back("ETag", "\"" + std::to_string(seen.assignment.version) + "\"");
  return response;
}

core::Result<Ownership> WhoseCourse(CourseApi& api,
                                    const Principal& who,
                                    std::int64_t course,
                                    bool* member) {
  auto teaches = api.accounts.Teaches(who.user_id, course);
  if (!teaches) return teaches.error();
  auto attends = api.accounts.Attends(who.user_id, course);
  if (!attends) return attends.error();
  *member = teaches.value() || attends.value();
  return teaches.value()   ? Ownership::kOwn
         : attends.value() ? Ownership::kCourse
                           : Ownership::kForeign;
}

}  // namespace

core::Result<SeenAssignment> AssignmentFor(CourseApi& api, const Principal& who, std::int64_t id) {
  auto assignment = api.assignments.Get(id);
  if (!assignment) return assignment.error();
  SeenAssignment seen;
  const auto whose = WhoseCourse(api, who, assignment.value().course, &seen.member);
  if (!whose) return whose.error();
  const core::Status allowed = Authorize(who, Operation::kReadCourse, whose.value());
  if (!allowed.ok()) return allowed.error();
  seen.assignment = std::move(assignment).value();
  seen.whose = whose.value();
  return seen;
}

core::Result<SeenAssignment> ManagedAssignment(CourseApi& api, const ApiRequest& request) {
  const auto id = PathNumber(request);
  if (!id) return id.error();
  auto seen = AssignmentFor(api, request.who, id.value());
  if (!seen) return seen;
  const core::Status allowed = Authorize(request.who, Operation::kManageCourse, seen.value().whose);
  if (!allowed.ok()) return allowed.error();
  return seen;
}

core::Result<HttpResponse> ListAssignments(CourseApi& api, const ApiRequest& request) {
  const auto page = PageOf(request.http);
  if (!page) return page.error();
  const bool all = Allowed(request.who.role, Operation::kReadCourse, Ownership::kForeign);
  const auto mine = all ? std::nullopt : std::optional(request.who.user_id);
  auto list = api.assignments.List(mine, page.value().after, page.value().limit);
  if (!list) return list.error();
  json::array items;
  std::int64_t last = 0;
  for (Assignment& each : list.value()) {
    SeenAssignment seen;
    const auto whose = WhoseCourse(api, request.who, each.course, &seen.member);
    if (!whose) return whose.error();
    last = each.id;
    seen.whose = whose.value();
    seen.assignment = std::move(each);
    items.push_back(AssignmentToJson(api, request.who, seen));
  }
  return page.value().Answer(std::move(items), last);
}

core::Result<HttpResponse> CreateAssignment(CourseApi& api, const ApiRequest& request) {
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
  const core::Status times = CheckTimes(assignment, api.clock.Wall());
  if (!times.ok()) return times.error();
  const auto graded = course::ParseRubric(rubric != nullptr ? *rubric : json::object{});
  if (!graded) return graded.error();
  assignment.rubric_json = json::serialize(ToJson(graded.value()));
  bool member = false;
  const auto whose = WhoseCourse(api, request.who, assignment.course, &member);
  if (!whose) return whose.error();
  if (!Authorize(request.who, Operation::kManageCourse, whose.value()).ok()) {
    return Error{ErrorCode::kInvalid, "You teach no such course.", "/course", "no_course"};
  }
  const core::Status taken = TakeSet(api, request, plan, assignment);
  if (!taken.ok()) return taken.error();
  assignment.secret = NewSecret("");
  auto made = api.assignments.Create(std::move(assignment));
  if (!made) return made.error();
  const core::Status used = api.fault_sets.MarkUsed(made.value().fault_set);
  if (!used.ok()) return used.error();
  api.audit.Add(request.who,
                "create_assignment",
                "assignment:" + std::to_string(made.value().id),
                made.value().name);
  return JsonResponse(
      AssignmentToJson(api, request.who, {std::move(made).value(), Ownership::kOwn, member}), 201);
}

core::Result<HttpResponse> PreviewAssignment(CourseApi& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string bench = in.Text("bench", kNameBytesMax);
  const json::object* pool = in.ObjectOrNull("pool");
  const json::object* plan = in.ObjectOrNull("plan");
  if (auto error = in.Finish()) return *error;
  const auto judged =
      JudgePool(api, request, bench, pool != nullptr ? *pool : json::object{}, plan);
  if (!judged) return judged.error();
  return JsonResponse(ToJson(judged.value()));
}

core::Result<HttpResponse> GetAssignment(CourseApi& api, const ApiRequest& request) {
  const auto id = PathNumber(request);
  if (!id) return id.error();
  const auto seen = AssignmentFor(api, request.who, id.value());
  if (!seen) return seen.error();
  return AssignmentResponse(api, request, seen.value());
}

namespace {

void Audit(CourseApi& api,
           const ApiRequest& request,
           const std::string& verb,
           const Assignment& of,
           const std::string& more = {}) {
  api.audit.Add(request.who, verb, "assignment:" + std::to_string(of.id), of.name + more);
}

core::Result<HttpResponse> Extended(CourseApi& api,
                                    const ApiRequest& request,
                                    const std::optional<WallTime>& due) {
  auto seen = ManagedAssignment(api, request);
  if (!seen) return seen.error();
  const auto account = PathNumber(request, "user");
  if (!account) return account.error();
  const std::int64_t id = seen.value().assignment.id;
  Principal student;
  student.user_id = account.value();
  bool member = false;
  const auto whose = WhoseCourse(api, student, seen.value().assignment.course, &member);
  if (!whose) return whose.error();
  if (!member) {
    return NotYours();
  }
  const core::Status done = api.assignments.Extend(id, account.value(), due);
  if (!done.ok()) return done.error();
  Audit(api,
        request,
        "extend_assignment",
        seen.value().assignment,
        ": user:" + std::to_string(account.value()) + (due ? " " + Iso8601(*due) : ""));
  auto now = AssignmentFor(api, request.who, id);
  if (!now) return now.error();
  return AssignmentResponse(api, request, now.value());
}

}  // namespace

core::Result<HttpResponse> ChangeAssignment(CourseApi& api, const ApiRequest& request) {
  const auto version = RequiredVersion(request);
  if (!version) return version.error();
  auto seen = ManagedAssignment(api, request);
  if (!seen) return seen.error();
  ObjectReader in(request.body, "");
  const core::Status terms = ReadTerms(in, seen.value().assignment);
  const json::object* rubric = in.ObjectOrNull("rubric");
  if (auto error = in.Finish()) return *error;
  if (!terms.ok()) return terms.error();
  if (rubric != nullptr) {
    const auto graded = course::ParseRubric(*rubric);
    if (!graded) return graded.error();
    seen.value().assignment.rubric_json = json::serialize(ToJson(graded.value()));
  }
  // It may end at once.
  const core::Status times = CheckTimes(seen.value().assignment, WallTime{});
  if (!times.ok()) return times.error();
  auto changed = api.assignments.Change(seen.value().assignment, version.value());
  if (!changed) return changed.error();
  std::string members;
  for (const auto& [name, value] : request.body) {
    members += (members.empty() ? ": " : ", ") + std::string(name);
  }
  Audit(api, request, "change_assignment", changed.value(), members);
  seen.value().assignment = std::move(changed).value();
  return AssignmentResponse(api, request, seen.value());
}

core::Result<HttpResponse> ExtendAssignment(CourseApi& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  (void)in.Text("due", kNameBytesMax);
  WallTime due{};
  const core::Status read = ReadTime(in, "due", due);
  if (auto error = in.Finish()) return *error;
  if (!read.ok()) return read.error();
  return Extended(api, request, due);
}

core::Result<HttpResponse> EndExtension(CourseApi& api, const ApiRequest& request) {
  return Extended(api, request, std::nullopt);
}

core::Result<HttpResponse> DeleteAssignment(CourseApi& api, const ApiRequest& request) {
  const auto seen = ManagedAssignment(api, request);
  if (!seen) return seen.error();
  const core::Status done = api.assignments.Delete(seen.value().assignment.id);
  if (!done.ok()) return done.error();
  Audit(api, request, "delete_assignment", seen.value().assignment);
  return NoContent();
}

}  // namespace faultlab::server
