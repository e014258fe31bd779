// fault-sets: an instructor's named fault schedules.
#include <boost/json.hpp>

#include "server/api/json_reader.h"
#include "server/api/lab/handlers.h"
#include "server/api/run_body.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::FaultSet;

json::object SetToJson(const FaultSet& set) {
  json::object out{{"id", set.id},
                   {"name", set.name},
                   {"course", nullptr},
                   {"visible", set.visible},
                   {"version", set.version},
                   {"used", set.used},
                   {"replaces", nullptr},
                   {"faults", json::parse(set.faults_json)},
                   {"created_at", Iso8601(set.created_at)}};
  if (set.course_id != 0) out["course"] = set.course_id;
  if (set.replaces != 0) out["replaces"] = set.replaces;
  return out;
}

HttpResponse SetResponse(const FaultSet& set, int status) {
  HttpResponse response = JsonResponse(SetToJson(set), status);
  response.headers.emplace_back("ETag", "\"" + std::to_string(set.version) + "\"");
  return response;
}

/// Own: its author, or a teacher of its course. Course: a student of it, and only while visible.
core::Result<Ownership> OwnershipOfSet(LabApi& lab, const Principal& who, const FaultSet& set) {
  if (set.author == who.user_id && who.signed_in()) return Ownership::kOwn;
  if (set.course_id == 0) return Ownership::kForeign;
  auto teaches = lab.accounts.Teaches(who.user_id, set.course_id);
  if (!teaches) return teaches.error();
  if (teaches.value()) return Ownership::kOwn;
  auto attends = lab.accounts.Attends(who.user_id, set.course_id);
  if (!attends) return attends.error();
  return attends.value() && set.visible ? Ownership::kCourse : Ownership::kForeign;
}

/// Reads name, visible, faults into `set`; faults are checked as those of a run are.
core::Status ReadSet(const ApiRequest& request, FaultSet& set) {
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
  set.name = in.Text("name", 200);
  set.visible = in.BooleanOr("visible", true);
  if (in.Has("course")) set.course_id = in.Integer("course", 1, INT64_MAX);
  const json::array* faults = in.ArrayOrNull("faults", kRunFaultsMax);
  if (auto error = in.Finish()) return *error;
  if (faults == nullptr || faults->empty()) {
    return core::Error{core::ErrorCode::kInvalid, "Give at least one fault.", "/faults"};
  }
  set.faults_json = json::serialize(*faults);
  // The longest run, so that only what no run could take is refused here.
  const json::object as_run{{"duration_s", kRunSecondsMax}, {"faults", *faults}};
  auto parsed = ParseRunBody(json::serialize(as_run), 1);
  if (!parsed) return parsed.error();
  return core::Done{};
}

core::Status MayTeach(LabApi& lab, const Principal& who, std::int64_t course) {
  if (course == 0 || who.role == Role::kAdmin) return core::Done{};
  auto teaches = lab.accounts.Teaches(who.user_id, course);
  if (!teaches) return teaches.error();
  if (teaches.value()) return core::Done{};
  return core::Error{core::ErrorCode::kInvalid, "You teach no such course.", "/course"};
}

}  // namespace

core::Result<FaultSet> AuthorizedFaultSet(ApiContext& api,
                                          const Principal& who,
                                          std::int64_t id,
                                          Operation operation) {
  auto set = api.lab->fault_sets.Get(id);
  if (!set) return set.error();
  auto ownership = OwnershipOfSet(*api.lab, who, set.value());
  if (!ownership) return ownership.error();
  const core::Status allowed = Authorize(who, operation, ownership.value());
  if (!allowed.ok()) return allowed.error();
  return set;
}

core::Result<std::string> ExpandFaultSet(ApiContext& api,
                                         const Principal& who,
                                         std::string_view body) {
  auto parsed = ParseJsonObject(body);
  if (!parsed) return parsed.error();
  json::object& object = parsed.value();
  const auto found = object.find("fault_set");
  if (found == object.end()) return std::string(body);
  const core::Error refused{
      core::ErrorCode::kInvalid, "There is no such fault set for you.", "/fault_set"};
  if (api.lab == nullptr || !found->value().is_int64()) return refused;
  if (object.contains("faults")) {
    return core::Error{
        core::ErrorCode::kInvalid, "Give faults or a fault_set, not both.", "/fault_set"};
  }
  const std::int64_t id = found->value().get_int64();
  auto set = AuthorizedFaultSet(api, who, id, Operation::kReadFaultSet);
  if (!set) return refused;
  const core::Status used = api.lab->fault_sets.MarkUsed(id);
  if (!used.ok()) return used.error();
  object.erase("fault_set");
  object["faults"] = json::parse(set.value().faults_json);
  return json::serialize(object);
}

core::Result<HttpResponse> ListFaultSets(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto sets = lab.value()->fault_sets.List();
  if (!sets) return sets.error();
  json::array items;
  for (const FaultSet& set : sets.value()) {
    auto ownership = OwnershipOfSet(*lab.value(), request.who, set);
    if (!ownership) return ownership.error();
    if (Authorize(request.who, Operation::kReadFaultSet, ownership.value()).ok()) {
      items.push_back(SetToJson(set));
    }
  }
  return JsonResponse(json::object{{"items", std::move(items)}, {"next_cursor", nullptr}});
}

core::Result<HttpResponse> CreateFaultSet(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  FaultSet set;
  set.author = request.who.user_id;
  set.created_at = api.clock.Wall();
  const core::Status read = ReadSet(request, set);
  if (!read.ok()) return read.error();
  const core::Status teaches = MayTeach(*lab.value(), request.who, set.course_id);
  if (!teaches.ok()) return teaches.error();
  auto made = lab.value()->fault_sets.Create(set);
  if (!made) return made.error();
  Audit(api, request.who, "create_fault_set", "fault_set:" + std::to_string(made.value().id), "");
  return SetResponse(made.value(), 201);
}

core::Result<HttpResponse> ChangeFaultSet(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto id = PathNumber(request);
  if (!id) return id.error();
  auto version = RequiredVersion(request);
  if (!version) return version.error();
  auto set = AuthorizedFaultSet(api, request.who, id.value(), Operation::kManageFaultSet);
  if (!set) return set.error();
  FaultSet next = set.value();
  const core::Status read = ReadSet(request, next);
  if (!read.ok()) return read.error();
  if (next.course_id != set.value().course_id) {
    return core::Error{core::ErrorCode::kInvalid, "A set stays in its course.", "/course"};
  }
  auto changed = lab.value()->fault_sets.Change(next, version.value());
  if (!changed) return changed.error();
  Audit(api, request.who, "change_fault_set", "fault_set:" + std::to_string(id.value()), "");
  return SetResponse(changed.value(), 200);
}

core::Result<HttpResponse> DeleteFaultSet(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto id = PathNumber(request);
  if (!id) return id.error();
  auto version = RequiredVersion(request);
  if (!version) return version.error();
  auto set = AuthorizedFaultSet(api, request.who, id.value(), Operation::kManageFaultSet);
  if (!set) return set.error();
  const core::Status done = lab.value()->fault_sets.Delete(id.value(), version.value());
  if (!done.ok()) return done.error();
  Audit(api, request.who, "delete_fault_set", "fault_set:" + std::to_string(id.value()), "");
  return NoContent();
}

}  // namespace faultlab::server
