// assignment_request: what a request says of an assignment, and whether it can be given to a class.
#include "server/api/course/assignment_request.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <utility>

#include "core/isolability/isolability.h"
#include "server/course/fault_pool.h"
#include "server/diagnosis_json/isolability_question.h"
#include "server/json/plain_numbers.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using course::Assignment;

constexpr std::int64_t kAttemptsMax = 50;
/// What must follow the last onset, so that something can be seen.
constexpr double kSeenAfterS = 1.0;
constexpr int kPoolWindowMax = 200;

/// By a stretch of the fault as long as every trial has it, where it begins last.
core::Result<core::Isolability> JudgePool(const core::Bench& bench,
                                          const ExperimentPlan& plan,
                                          const course::FaultPool& pool,
                                          std::vector<core::FaultSize> faults) {
  IsolabilityQuestion question;
  question.bench = &bench;
  question.excitation = plan.excitation;
  question.channels = "all";
  double latest_s = 0.0;
  for (const course::PoolItem& item : pool.items) latest_s = std::max(latest_s, item.onset_to_s);
  const double left_s = plan.duration_s - latest_s;
  question.window_samples =
      std::clamp(static_cast<int>(std::lround(left_s / bench.period_s)), 10, kPoolWindowMax);
  question.faults = std::move(faults);
  TRY(const auto options, ToOptions(question));
  return core::AnalyseIsolability(options);
}

std::vector<core::FaultSize> SizesOf(const std::vector<core::Fault>& faults) {
  std::vector<core::FaultSize> sizes;
  for (const core::Fault& fault : faults) sizes.push_back({fault.component, fault.value});
  return sizes;
}

core::Status CheckSolvable(const core::Bench& bench,
                           const ExperimentPlan& plan,
                           const course::FaultPool& pool) {
  TRY(const auto judged, JudgePool(bench, plan, pool, SizesOf(course::Representatives(pool))));
  for (const core::FaultIsolability& each : judged.faults) {
    if (each.visible) continue;
    const std::string symbol(core::Name(each.fault.component));
    const std::string value = WithPlainNumbers(json::serialize(json::value(each.fault.value)));
    return core::Refuse(
        "fault_not_visible", "/fault_set", {{"component", symbol}, {"value", value}});
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
    return core::Refuse(
        "pool_not_of_relays", "/fault_set", {{"component", core::Name(item.component)}});
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
  if (in.BooleanOr(course::kFreeExcitation, false)) plan[course::kFreeExcitation] = true;
  if (auto error = in.Finish()) return *error;
  return plan;
}

/// A plan as the assignment keeps it, and as it is played.
struct PlayedPlan {
  json::object kept;
  ExperimentPlan plan;
};

core::Result<PlayedPlan> ReadPlayedPlan(Api& api,
                                        const ApiRequest& request,
                                        const json::object* wanted,
                                        const std::string& bench,
                                        const course::FaultPool& pool,
                                        RigPool::Like on) {
  TRY(auto body, ReadPlan(wanted, bench));
  json::object usual = body;
  usual.erase(course::kFreeExcitation);
  auto plan = api.experiments.Read(usual);
  if (!plan) return refusal::In(plan.error(), "/plan");
  // What no rig plays, no student could begin.
  const core::Status played = api.experiments.Check(request.who, plan.value(), on);
  if (!played.ok()) return refusal::In(played.error(), "/plan");
  if (course::LastsUntil(pool) + kSeenAfterS > plan.value().duration_s) {
    return core::Refuse("run_ends_with_fault", "/plan/duration_s");
  }
  body["duration_s"] = plan.value().duration_s;
  return PlayedPlan{std::move(body), std::move(plan).value()};
}

}  // namespace

core::Status ReadTime(ObjectReader& in, const char* name, WallTime& time) {
  constexpr std::size_t kTimeBytesMax = 40;
  const std::string text = in.TextOr(name, "", kTimeBytesMax);
  if (text.empty()) return core::Done{};
  TRY(time, ParseIso8601(text, std::string("/") + name));
  return core::Done{};
}

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
  return core::Refuse("due_not_ahead", "/due");
}

core::Status TakeSet(Api& api,
                     const ApiRequest& request,
                     const json::object* wanted,
                     Assignment& assignment) {
  const auto set =
      api.fault_set_access.Find(request.who, assignment.fault_set, Operation::kManageFaultSet);
  if (!set) return core::Refuse("no_fault_set", "/fault_set");
  if (set.value().pool_json.empty()) {
    return core::Refuse("set_without_pool", "/fault_set");
  }
  const auto bench = api.benches.Find(set.value().bench);
  if (!bench) return refusal::At(bench.error(), "/fault_set");
  assignment.bench = bench.value()->name;
  assignment.pool_json = set.value().pool_json;
  TRY(const auto pool, course::ParsePool(assignment.pool_json, *bench.value()));
  if (assignment.on_bench) {
    TRY_DONE(CheckForBenches(pool));
  }
  using enum RigPool::Like;
  const RigPool::Like on = assignment.on_bench ? kAnyRig : kSimulator;
  TRY(const auto played, ReadPlayedPlan(api, request, wanted, assignment.bench, pool, on));
  assignment.plan_json = json::serialize(played.kept);
  return CheckSolvable(*bench.value(), played.plan, pool);
}

core::Result<JudgedPool> JudgePool(Api& api,
                                   const ApiRequest& request,
                                   const std::string& bench_name,
                                   const json::object& pool,
                                   const json::object* wanted,
                                   const course::Rubric& rubric) {
  const auto bench = api.benches.Find(bench_name);
  if (!bench) return refusal::At(bench.error(), "/bench");
  TRY(const auto read, course::ParsePool(pool, *bench.value()));
  TRY(const auto played,
      ReadPlayedPlan(api, request, wanted, bench.value()->name, read, RigPool::Like::kAnyRig));
  std::vector<core::FaultSize> faults = SizesOf(course::HardestToSee(read, bench.value()->nominal));
  const std::size_t shown = faults.size();
  const std::vector<course::LikelyDraw> draws = course::LikelyDraws(read);
  for (const course::LikelyDraw& draw : draws) {
    if (draw.fault) faults.push_back(*draw.fault);
  }
  JudgedPool out;
  TRY(out.isolability, JudgePool(*bench.value(), played.plan, read, std::move(faults)));
  std::vector<core::FaultIsolability>& judged = out.isolability.faults;
  out.expected = course::ExpectGrade(
      rubric, draws, std::span(judged).subspan(shown), out.isolability.kl_separable_nats);
  judged.resize(shown);
  return out;
}

}  // namespace faultlab::server
