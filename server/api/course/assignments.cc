// assignments: what a course's students are to diagnose, and until when.
#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <utility>

#include "core/isolability/isolability.h"
#include "server/api/course/handlers.h"
#include "server/auth/secrets.h"
#include "server/course/fault_pool.h"
#include "server/course/grade.h"
#include "server/diagnosis_json/isolability_question.h"
#include "server/json/json_reader.h"
#include "server/json/plain_numbers.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using core::Error;
using core::ErrorCode;
using course::Assignment;

constexpr std::int64_t kAttemptsMax = 50;
/// What must follow the last onset, so that something can be seen.
constexpr double kSeenAfterS = 1.0;
constexpr int kWindowMax = 200;

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
                   {"version", of.version},
                   {"extensions", nullptr},
                   {"attempts", of.attempts},
                   {"on", of.on_bench ? "bench" : "simulator"},
                   {"reveal", of.reveal_at_once ? "answer" : "due"},
                   {"teaches", seen.whose != Ownership::kCourse},
                   {"created_at", Iso8601(of.created_at)}};
  // What faults may come is the teacher's to know.
  if (seen.whose == Ownership::kCourse) return out;
  out["fault_set"] = of.fault_set;
  out["pool"] = json::parse(of.pool_json);
  json::array extensions;
  for (const auto& [account, due] : of.extensions) {
    extensions.push_back(json::object{{"account", account}, {"due", Iso8601(due)}});
  }
  out["extensions"] = std::move(extensions);
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

/// A stretch of the fault as long as every trial has it, where it begins last.
core::Status CheckSolvable(const core::Bench& bench,
                           const ExperimentPlan& plan,
                           const course::FaultPool& pool) {
  IsolabilityQuestion question;
  question.bench = &bench;
  question.excitation = plan.excitation;
  question.channels = "all";
  double latest_s = 0.0;
  for (const course::PoolItem& item : pool.items) latest_s = std::max(latest_s, item.onset_to_s);
  const double left_s = plan.duration_s - latest_s;
  question.window_samples =
      std::clamp(static_cast<int>(std::lround(left_s / bench.period_s)), 10, kWindowMax);
  for (const core::Fault& fault : course::Representatives(pool)) {
    question.faults.push_back({fault.component, fault.value});
  }
  const auto options = ToOptions(question);
  if (!options) return options.error();
  const auto judged = core::AnalyseIsolability(options.value());
  if (!judged) return judged.error();
  for (const core::FaultIsolability& each : judged.value().faults) {
    if (each.visible) continue;
    const std::string symbol(core::Name(each.fault.component));
    const std::string value = WithPlainNumbers(json::serialize(json::value(each.fault.value)));
    return Error{ErrorCode::kInvalid,
                 "Nobody can see " + symbol + " = " + value +
                     " in this experiment: change the fault, or what is played.",
                 "/fault_set",
                 "fault_not_visible",
                 {{"component", symbol}, {"value", value}}};
  }
  return core::Done{};
}

/// Whether relays can switch all that may be drawn.
core::Status CheckForBenches(const course::FaultPool& pool) {
  constexpr double kSame = 1e-9;
  for (const course::PoolItem& item : pool.items) {
    const auto connects = [&](double value) {
      return std::ranges::any_of(item.component.info().positions, [&](const auto& position) {
        return std::abs(position.value - value) <= kSame * value;
      });
    };
    const bool all = !item.values.empty() && std::ranges::all_of(item.values, connects);
    if (all && core::IsSwitched(item.component)) continue;
    const std::string symbol(core::Name(item.component));
    return Error{ErrorCode::kInvalid,
                 "On a bench, " + symbol + " has only the values that relays connect: list these.",
                 "/fault_set",
                 "pool_not_of_relays",
                 {{"component", symbol}}};
  }
  return core::Done{};
}

/// The part of a run's plan that an assignment decides, as it is kept.
core::Result<json::object> ReadPlan(const json::object* wanted, const std::string& bench) {
  json::object plan{{"bench", bench}};
  if (wanted == nullptr) return plan;
  ObjectReader in(*wanted, "/plan");
  const auto keep = [&](const char* name) {
    if (in.Has(name)) plan[name] = wanted->at(name);
  };
  keep("duration_s");
  keep("period_s");
  keep("excitation");
  if (auto error = in.Finish()) return *error;
  return plan;
}

core::Status ReadTime(ObjectReader& in, const char* name, WallTime& time) {
  constexpr std::size_t kTimeBytesMax = 40;
  const std::string text = in.TextOr(name, "", kTimeBytesMax);
  if (text.empty()) return core::Done{};
  const auto read = ParseIso8601(text, std::string("/") + name);
  if (!read) return read.error();
  time = read.value();
  return core::Done{};
}

/// What may change later: name, times, attempts, release. What is absent stays.
core::Status ReadTerms(ObjectReader& in, Assignment& assignment) {
  if (in.Has("name")) assignment.name = in.Text("name", kNameBytesMax);
  assignment.attempts =
      static_cast<int>(in.IntegerOr("attempts", assignment.attempts, 1, kAttemptsMax));
  const std::string_view before = assignment.reveal_at_once ? "answer" : "due";
  assignment.reveal_at_once = in.WordOr("reveal", before, {"due", "answer"}) == "answer";
  if (const core::Status opens = ReadTime(in, "opens", assignment.opens); !opens.ok()) return opens;
  return ReadTime(in, "due", assignment.due);
}

core::Status CheckTimes(const Assignment& assignment, WallTime earliest_due) {
  if (assignment.due > std::max(assignment.opens, earliest_due)) return core::Done{};
  return Error{ErrorCode::kInvalid,
               "The due time must lie ahead, and after the assignment opens.",
               "/due",
               "due_not_ahead"};
}

/// Bench, pool and plan, if the caller may use the set and a trial with them can be solved.
core::Status TakeSet(CourseApi& api,
                     const ApiRequest& request,
                     const json::object* wanted,
                     Assignment& assignment) {
  const auto set =
      api.fault_set_access.Find(request.who, assignment.fault_set, Operation::kManageFaultSet);
  if (!set) return refusal::At(refusal::NoFaultSet(), "/fault_set");
  if (set.value().pool_json.empty()) {
    return Error{ErrorCode::kInvalid,
                 "This set plays all its faults in every run: give it a pool to draw from.",
                 "/fault_set",
                 "set_without_pool"};
  }
  const auto bench = api.benches.Find(set.value().bench);
  if (!bench) return refusal::At(bench.error(), "/fault_set");
  assignment.bench = bench.value()->name;
  assignment.pool_json = set.value().pool_json;
  const auto pool = course::ParsePool(assignment.pool_json, *bench.value());
  if (!pool) return pool.error();
  if (assignment.on_bench) {
    const core::Status switched = CheckForBenches(pool.value());
    if (!switched.ok()) return switched;
  }
  auto body = ReadPlan(wanted, assignment.bench);
  if (!body) return body.error();
  auto plan = api.experiments.Read(body.value());
  if (!plan) return refusal::In(plan.error(), "/plan");
  // What no simulator plays, no student could begin.
  const core::Status played = api.experiments.Check(request.who, plan.value());
  if (!played.ok()) return refusal::In(played.error(), "/plan");
  if (course::LastsUntil(pool.value()) + kSeenAfterS > plan.value().duration_s) {
    return Error{ErrorCode::kInvalid,
                 "The run must go on for a second after the last fault of the set.",
                 "/plan/duration_s",
                 "fault_outside_run"};
  }
  body.value()["duration_s"] = plan.value().duration_s;
  assignment.plan_json = json::serialize(body.value());
  return CheckSolvable(*bench.value(), plan.value(), pool.value());
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
    return Error{ErrorCode::kNotFound, "no such thing, or not yours to see", "", "not_yours"};
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
  if (auto error = in.Finish()) return *error;
  if (!terms.ok()) return terms.error();
  // It may end at once.
  const core::Status times = CheckTimes(seen.value().assignment, WallTime{});
  if (!times.ok()) return times.error();
  auto changed = api.assignments.Change(seen.value().assignment, version.value());
  if (!changed) return changed.error();
  Audit(api, request, "change_assignment", changed.value());
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
