#include "server/experiment/experiments.h"

#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/control/closed_loop/orders.h"
#include "hardware/bench/benches.h"
#include "hardware/replay_rig.h"
#include "hardware/rig_limits.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/experiment/baseline.h"
#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"
#include "server/run/refusals.h"
#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr double kReplayLongestS = 3600.0;
/// A motor warms up and cools down within an hour, which changes its resistance and its friction.
constexpr std::chrono::hours kLearntFor{1};
/// An older one may fit where the newest one does not.
constexpr int kBaselinesLookedAt = 10;

std::chrono::milliseconds LengthOf(const ExperimentPlan& plan) {
  return std::chrono::ceil<std::chrono::milliseconds>(
      std::chrono::duration<double>(plan.duration_s));
}

/// What happened to the plant in a recording; its replay shows it again.
std::vector<hardware::RigEvent> EventsOfThePlant(std::span<const RecordedEvent> recorded,
                                                 const core::Bench& bench) {
  std::vector<hardware::RigEvent> out;
  for (const RecordedEvent& each : recorded) {
    auto event = ToRigEvent(each, bench);
    const bool of_the_plant = event && (event->kind == hardware::RigEventKind::kFaultCommanded ||
                                        event->kind == hardware::RigEventKind::kRelayConfirmed ||
                                        event->kind == hardware::RigEventKind::kControlBegan ||
                                        event->kind == hardware::RigEventKind::kCompensated ||
                                        event->kind == hardware::RigEventKind::kCompensationEnded ||
                                        event->kind == hardware::RigEventKind::kGap);
    if (of_the_plant) out.push_back(std::move(*event));
  }
  return out;
}

/// The speed control begins when the rig is learnt. Refuses a run that ends before it.
core::Status PlaceControl(const hardware::RigDescription& rig, RunRequest& run) {
  if (!run.plan.control) return core::Done{};
  const double learnt_s = run.diagnosis.calibration ? 0.0 : run.diagnosis.healthy_to_s;
  const double from_s = learnt_s + core::kControlAfterLearningS;
  run.plan.control->from = std::llround(from_s / run.plan.period_s);
  if (run.plan.control->from >= static_cast<std::int64_t>(run.plan.uc_v.size())) {
    return core::Refuse("control_after_end", "/duration_s", {{"from_s", from_s}});
  }
  json::object shown = json::parse(run.plan_json).as_object();
  json::object& control = shown["control"].as_object();
  control["from_s"] = from_s;
  if (!rig.profile.empty()) control["profile"] = rig.profile;
  run.plan_json = json::serialize(shown);
  return core::Done{};
}

void Seal(const ExperimentPlan& plan, RunRequest& run) {
  run.witness = plan.witness;
  run.hidden_faults = true;
  run.plan_json = SealedPlan(run.plan_json, plan.trial);
  LearnNothing(run.diagnosis);
}

}  // namespace

/// Texts that are not there are empty; what is no text is refused when the plan is read.
core::Result<const core::Bench*> Experiments::BenchOf(const json::object& body) {
  const auto text = [&body](const char* name) -> std::string {
    const json::value* value = body.if_contains(name);
    return value != nullptr && value->is_string() ? std::string(value->get_string()) : "";
  };
  const std::string rig = text("rig");
  const std::string asked = text("bench");
  if (asked.size() > kBenchNameBytesMax) {
    return core::Error{
        core::ErrorCode::kInvalid, "No bench has so long a name.", "/bench", "bench_name_long"};
  }
  if (rig.empty()) {
    if (asked.empty()) return &parts_.benches.usual();
    return parts_.benches.Find(asked);
  }
  auto bench = BenchOfRig(parts_.rig_pool, parts_.benches, rig);
  if (!bench || asked.empty()) return bench;
  if (asked != bench.value()->id && asked != bench.value()->name) {
    return core::Refuse(
        "other_bench", "/bench", {{"rig", rig}, {"bench", bench.value()->name}, {"asked", asked}});
  }
  return bench;
}

core::Result<ExperimentPlan> Experiments::Read(const json::object& body) {
  TRY(const auto bench, BenchOf(body));
  return ParsePlan(body, *bench, parts_.default_seed);
}

core::Result<Work> Experiments::ReadWork(const json::object& body) {
  if (body.contains("diagnose")) {
    TRY(auto request, ParseDiagnosisRequest(body));
    return Work(std::move(request));
  }
  if (body.contains("methods")) {
    TRY(auto request, ParseMethodsRequest(body));
    return Work(std::move(request));
  }
  TRY(auto plan, Read(body));
  return Work(std::move(plan));
}

core::Result<Work> Experiments::ReadWork(std::string_view document) {
  TRY(auto body, ParseJsonObject(document));
  const bool plan =
      !body.contains("diagnose") && !body.contains("methods") && !body.contains("recording");
  // Programs that knew the paper's bench alone named none.
  if (plan && !body.contains("bench")) body["bench"] = hardware::PaperBench().name;
  return ReadWork(body);
}

core::Status Experiments::TakeFaultSet(const Principal& who, ExperimentPlan& plan) {
  if (plan.fault_set == 0) return core::Done{};
  const auto set = parts_.fault_set_access.Find(who, plan.fault_set, Operation::kReadFaultSet);
  if (!set) {
    return core::Refuse("no_fault_set", "/fault_set");
  }
  if (!set.value().pool_json.empty()) return core::Refuse("set_to_draw_from", "/fault_set");
  if (set.value().bench != plan.bench->name) {
    return core::Refuse("fault_set_of_other_bench",
                        "/fault_set",
                        {{"its", set.value().bench}, {"bench", plan.bench->name}});
  }
  TRY(plan.faults, ParseFaults(set.value().faults_json, *plan.bench, plan.duration_s));
  if (!set.value().visible) plan.hidden_faults = true;
  plan.fault_set = 0;
  return core::Done{};
}

/// Room for a run that takes what others may want as well: whoever has a session always has it.
core::Result<std::shared_ptr<void>> Experiments::PlaceFor(const Principal& who,
                                                          StartedBy by,
                                                          RunKind kind,
                                                          std::int64_t samples) {
  const std::string caller = by == StartedBy::kJob ? std::string() : who.caller_key();
  auto place = parts_.places.Take(
      caller, kind, kind == RunKind::kReplay ? samples : 0, parts_.clock.Monotonic());
  if (!place || kind == RunKind::kLeased) return place;
  TRY_DONE(parts_.quota.MakeRoom(who, samples));
  return place;
}

RunKind Experiments::KindOn(const std::string& rig) const {
  if (rig.empty()) return RunKind::kSimulator;
  const auto found = parts_.rig_pool.Find(rig);
  // What is not there is refused with its own words by who holds it.
  return found.ok() && !NeedsSession(found.value()) ? RunKind::kSimulator : RunKind::kLeased;
}

core::Result<RunRequest> Experiments::Replay(const Principal& who,
                                             StartedBy by,
                                             const ExperimentPlan& plan) {
  auto record = parts_.recordings.Find(who, plan.recording, Operation::kReadRun);
  if (!record) return refusal::At(record.error(), "/recording");
  if (IsSealed(record.value().plan_json)) return core::Refuse("run_sealed", "/recording");
  const std::int64_t samples = record.value().samples;
  if (static_cast<double>(samples) * record.value().period_s > kReplayLongestS) {
    return core::Refuse("replay_too_long", "/recording", {{"longest_s", kReplayLongestS}});
  }
  TRY(auto place, PlaceFor(who, by, RunKind::kReplay, samples));
  using enum LongTurn::For;
  auto source = parts_.recordings.Load(
      std::move(record).value(), 0, kSampleIndexMax, by == StartedBy::kJob ? kJob : kPerson);
  if (!source) return refusal::At(source.error(), "/recording");
  Recording& recording = source.value();
  if (recording.samples.empty()) {
    return core::Refuse("empty_recording", "/recording");
  }
  const auto events = parts_.store.LoadEvents(plan.recording);
  if (!events) return refusal::At(events.error(), "/recording");
  hardware::ReplayRigOptions options;
  options.speed = by == StartedBy::kJob ? 0.0 : parts_.speed;
  options.events = EventsOfThePlant(events.value(), *recording.options.bench);
  options.bench = recording.options.bench;
  const double period_s = recording.record.period_s;
  RunRequest run;
  run.place = std::move(place);
  run.hidden_faults = plan.hidden_faults || HidesFaults(recording.record.plan_json);
  const std::string& of = recording.record.name.empty() ? plan.recording : recording.record.name;
  run.name = plan.name.empty() ? "replay of " + of : plan.name;
  run.plan = hardware::ReplayPlan(period_s);
  run.diagnosis = std::move(recording.options);
  std::shared_ptr<hardware::Rig> rig =
      hardware::MakeReplayRig(std::move(recording.samples), std::move(options));
  json::object shown = PlanToJson(plan, rig->description());
  shown["period_s"] = period_s;
  if (run.hidden_faults) shown["hidden_faults"] = true;
  run.plan_json = json::serialize(shown);
  run.hold = RigHandle(std::move(rig), by == StartedBy::kJob ? Pace::kFastest : Pace::kOfRig);
  return run;
}

/// The plan says which run's calibration it is, or why the newest one does not do. Without a
/// fitting one the run learns its own.
void Experiments::UseWhatWasLearnt(const Principal& who,
                                   const hardware::RigDescription& rig,
                                   RunRequest& run) {
  const core::Bench& bench = *run.diagnosis.bench;
  const auto newest = parts_.calibrations.List(rig.id, bench.id, kBaselinesLookedAt);
  if (!newest.ok()) return;
  const WallTime now = parts_.clock.Wall();
  const InputRange wanted = RangeOf(run.plan.uc_v);
  json::object shown = json::parse(run.plan_json).as_object();
  json::object refused;
  std::optional<std::vector<lab::CheckRecord>> checks;
  for (const RigCalibration& stored : newest.value()) {
    if (now > stored.at + kLearntFor) break;
    if (!stored.unfit.empty()) continue;
    auto calibration = ParseCalibration(stored.json, "The calibration of " + stored.run, bench);
    if (!calibration || calibration.value().period_s != run.plan.period_s) continue;
    const bool own = stored.owner == who.owner_key() && who.signed_in();
    json::object about{{"run", stored.run}, {"at", calibration.value().dated}, {"own", own}};
    const char* why = nullptr;
    if (!Covers(stored.input, wanted)) {
      why = "input";
    } else if (!own) {
      if (!checks) {
        auto list = parts_.checks.List(rig.id);
        checks = list ? std::move(list).value() : std::vector<lab::CheckRecord>{};
      }
      if (!IsConfirmed(*checks, stored.at, calibration.value(), bench, rig.delta_s)) {
        why = "unconfirmed";
      }
    }
    if (why == nullptr) {
      run.diagnosis.calibration = std::move(calibration).value();
      shown["calibration"] = std::move(about);
      refused.clear();
      break;
    }
    if (refused.empty()) {
      about["reason"] = why;
      refused = std::move(about);
    }
  }
  if (!refused.empty()) shown["calibration_refused"] = std::move(refused);
  run.plan_json = json::serialize(shown);
}

core::Status Experiments::AwaitTurn(const Principal& who, const ExperimentPlan& plan) {
  if (!plan.rig.empty()) return core::Done{};
  return parts_.rigs.AwaitTurn(who, *plan.bench, LengthOf(plan));
}

void Experiments::LeaveLine(const Principal& who, const ExperimentPlan& plan) {
  if (plan.rig.empty()) parts_.rigs.LeaveLine(who, *plan.bench);
}

core::Result<RunRequest> Experiments::OnRig(const Principal& who,
                                            StartedBy by,
                                            const ExperimentPlan& wanted) {
  ExperimentPlan plan = wanted;
  if (!plan.seed) plan.seed = parts_.draw_seed();
  const auto planned = static_cast<std::int64_t>(plan.duration_s / plan.period_s);
  TRY(auto place, PlaceFor(who, by, KindOn(plan.rig), planned));
  // The rig comes first, for any one may do: the plan is resolved for the one that runs it.
  TRY(auto hold, parts_.rigs.Hold(who, by, plan.rig, *plan.bench, LengthOf(plan)));
  const hardware::RigDescription& about = hold.rig().description();
  TRY(auto resolved, ResolvePlan(plan, about));
  RunRequest run;
  run.name = plan.name;
  run.hidden_faults = plan.hidden_faults;
  run.plan = std::move(resolved);
  run.plan_json = json::serialize(PlanToJson(plan, about));
  run.diagnosis = core::OptionsOf(*about.bench, plan.period_s);
  run.diagnosis.values = about.any_value ? core::ValuePrior::kNone : core::ValuePrior::kTable2;
  run.diagnosis.model =
      about.any_value ? core::ModelScope::kSimulator : core::ModelScope::kBuiltRig;
  if (plan.learn_if_needed) UseWhatWasLearnt(who, about, run);
  TRY_DONE(PlaceControl(about, run));
  if (plan.witness) Seal(plan, run);
  run.hold = std::move(hold);
  run.place = std::move(place);
  return run;
}

core::Result<RunSnapshot> Experiments::Start(const Principal& who,
                                             StartedBy by,
                                             ExperimentPlan plan) {
  const std::int64_t set = plan.fault_set;
  TRY_DONE(TakeFaultSet(who, plan));
  auto run = [&]() -> core::Result<RunRequest> {
    if (!plan.recording.empty()) return Replay(who, by, plan);
    const auto begin = [&] { return OnRig(who, by, plan); };
    return by == StartedBy::kPerson ? InTurn(who, plan, begin) : begin();
  }();
  if (!run) return run.error();
  if (set != 0) {
    TRY_DONE(parts_.fault_sets.MarkUsed(set));
  }
  RunRequest ready = std::move(run).value();
  TRY_DONE(parts_.benches.Keep(*ready.diagnosis.bench, parts_.clock.Wall()));
  ready.owner = who.owner_key();
  return parts_.runs.Start(std::move(ready));
}

core::Status Experiments::Check(const Principal& who, ExperimentPlan& plan, RigPool::Like on) {
  const core::Status taken = TakeFaultSet(who, plan);
  if (!taken.ok() || !plan.recording.empty()) return taken;
  const auto rig =
      plan.rig.empty() ? parts_.rig_pool.FindLike(*plan.bench, on) : parts_.rig_pool.Find(plan.rig);
  // Another server's: that one looks at the plan when it gets the job.
  if (!rig && parts_.rigs.IsKnownElsewhere(plan.rig)) return core::Done{};
  if (!rig) return rig.error();
  TRY(const auto resolved, ResolvePlan(plan, rig.value().description));
  // What the rig would say when it is armed; one that differs from its class may say more.
  const core::Status played =
      hardware::CheckExcitation(resolved, rig.value().description.bench->limits);
  return played.ok() ? played : refusal::At(played.error(), "/excitation");
}

}  // namespace faultlab::server
