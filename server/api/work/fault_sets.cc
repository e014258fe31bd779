// fault-sets: an instructor's named fault schedules.
#include <boost/json.hpp>
#include <map>

#include "server/api/api.h"
#include "server/course/fault_pool.h"
#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::value IdOrNull(std::int64_t id) {
  return id != 0 ? json::value(id) : json::value(nullptr);
}

/// @param bench  of the set, if a server has it now
json::object SetToJson(const FaultSet& set, const core::Bench* bench) {
  json::object out{{"id", set.id},
                   {"name", set.name},
                   {"bench", bench != nullptr ? bench->id : set.bench},
                   {"course", IdOrNull(set.course_id)},
                   {"visible", set.visible},
                   {"version", set.version},
                   {"used", set.used},
                   {"replaces", IdOrNull(set.replaces)},
                   {"faults", json::parse(set.faults_json)},
                   {"created_at", Iso8601(set.created_at)}};
  if (!set.pool_json.empty()) out["pool"] = json::parse(set.pool_json);
  return out;
}

const core::Bench* BenchOfSet(Api& api, const FaultSet& set) {
  const auto bench = api.benches.Find(set.bench);
  return bench.ok() ? bench.value() : nullptr;
}

HttpResponse SetResponse(Api& api, const FaultSet& set, int status) {
  return Versioned(JsonResponse(SetToJson(set, BenchOfSet(api, set)), status), set.version);
}

/// By name or id, as it is described now: a set is kept by the name of its bench.
core::Result<const core::Bench*> PresentBench(Api& api, const std::string& id_or_name) {
  if (id_or_name.empty()) return &api.benches.usual();
  const auto asked = api.benches.Find(id_or_name);
  const auto now = asked.ok() ? api.benches.Find(asked.value()->name) : asked;
  if (!now) return refusal::In(now.error(), "/bench");
  if (now.value()->id != asked.value()->id)
    return core::Refuse(
        "bench_has_changed", "/bench", {{"bench", now.value()->name}, {"now", now.value()->id}});
  return now;
}

/// Of a set to draw from: faults that stand for it, and students do not see it.
core::Status ReadPool(Api& api, const json::object& body, FaultSet& set) {
  TRY(const auto bench, PresentBench(api, set.bench));
  set.bench = bench->name;
  TRY(const auto pool, course::ParsePool(body, *bench));
  set.pool_json = json::serialize(ToJson(pool));
  set.faults_json = json::serialize(ToJson(course::Representatives(pool)));
  set.visible = false;
  return core::Done{};
}

/// Reads name, visible, and faults or a pool, into `set`; faults are checked as those of a run are.
core::Status ReadSet(Api& api, const ApiRequest& request, FaultSet& set) {
  ObjectReader in(request.body, "");
  set.name = in.Text("name", 200);
  set.visible = in.BooleanOr("visible", true);
  if (in.Has("bench")) set.bench = in.Text("bench", 64);
  if (in.Has("course")) set.course_id = in.Integer("course", 1, INT64_MAX);
  const json::array* faults = in.ArrayOrNull("faults", kRunFaultsMax);
  const json::object* pool = in.ObjectOrNull("pool");
  if (faults != nullptr && pool != nullptr) {
    in.Refuse("pool", "faults_or_pool");
  }
  if (auto error = in.Finish()) return *error;
  if (pool != nullptr) return ReadPool(api, *pool, set);
  set.pool_json.clear();
  if (faults == nullptr || faults->empty()) {
    return core::Refuse("no_faults", "/faults");
  }
  set.faults_json = json::serialize(*faults);
  TRY(const auto bench, PresentBench(api, set.bench));
  set.bench = bench->name;
  // The longest run, so that only what no run could take is refused here.
  TRY_DONE(ParseFaults(*faults, *bench, kRunSecondsMax));
  return core::Done{};
}

core::Status MayTeach(Api& api, const Principal& who, std::int64_t course) {
  if (course == 0 || who.role == Role::kAdmin) return core::Done{};
  TRY(auto teaches, api.accounts.Teaches(who.user_id, course));
  if (teaches) return core::Done{};
  return core::Refuse("no_course", "/course");
}

struct Managed {
  FaultSet set;
  std::int64_t version = 0;  ///< that the caller saw
};

/// The set of the path's {id}, if the caller may change it and says which version they saw.
core::Result<Managed> ManagedSet(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(const auto version, RequiredVersion(request));
  TRY(auto set, api.fault_set_access.Find(request.who, id, Operation::kManageFaultSet));
  return Managed{std::move(set), version};
}

core::Result<HttpResponse> ListFaultSets(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  const bool all = Authorize(request.who, Operation::kReadFaultSet, Ownership::kForeign).ok();
  std::optional<FaultSets::Reader> reader;
  if (!all) {
    const bool makes = Authorize(request.who, Operation::kManageFaultSet, Ownership::kOwn).ok();
    reader = {request.who.user_id, makes};
  }
  TRY(auto sets, api.fault_sets.List(reader, page.after, page.limit));
  json::array items;
  std::map<std::string, const core::Bench*> benches;
  for (const FaultSet& set : sets) {
    const auto [bench, is_new] = benches.try_emplace(set.bench);
    if (is_new) bench->second = BenchOfSet(api, set);
    items.push_back(SetToJson(set, bench->second));
  }
  return page.Answer(std::move(items), sets.empty() ? 0 : sets.back().id);
}

core::Result<HttpResponse> CreateFaultSet(Api& api, const ApiRequest& request) {
  FaultSet set;
  set.author = request.who.user_id;
  set.created_at = api.clock.Wall();
  TRY_DONE(ReadSet(api, request, set));
  TRY_DONE(MayTeach(api, request.who, set.course_id));
  TRY(auto made, api.fault_sets.Create(set));
  api.audit.Add(request.who, "create_fault_set", "fault_set:" + std::to_string(made.id), "");
  return SetResponse(api, made, 201);
}

core::Result<HttpResponse> ChangeFaultSet(Api& api, const ApiRequest& request) {
  TRY(const auto managed, ManagedSet(api, request));
  const auto& [set, version] = managed;
  FaultSet next = set;
  TRY_DONE(ReadSet(api, request, next));
  if (next.course_id != set.course_id) {
    return core::Refuse("course_of_set_fixed", "/course");
  }
  TRY(auto changed, api.fault_sets.Change(next, version));
  api.audit.Add(request.who, "change_fault_set", "fault_set:" + std::to_string(set.id), "");
  return SetResponse(api, changed, 200);
}

core::Result<HttpResponse> DeleteFaultSet(Api& api, const ApiRequest& request) {
  TRY(const auto managed, ManagedSet(api, request));
  const auto& [set, version] = managed;
  TRY_DONE(api.fault_sets.Delete(set.id, version));
  api.audit.Add(request.who, "delete_fault_set", "fault_set:" + std::to_string(set.id), "");
  return NoContent();
}

}  // namespace

std::span<const ApiRoute> FaultSetsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "fault-sets", kReadFaultSet, kRole, ListFaultSets}.Takes("cursor limit"),
      {kPost, "fault-sets", kManageFaultSet, kRole, CreateFaultSet, kJson},
      {kPut, "fault-sets/{id}", kManageFaultSet, kRole, ChangeFaultSet, kJson},
      {kDelete, "fault-sets/{id}", kManageFaultSet, kRole, DeleteFaultSet},
  });
  return kRoutes;
}

}  // namespace faultlab::server
