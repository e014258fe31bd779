#include "server/course/blind_trials.h"

#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <iterator>
#include <utility>

#include "core/diagnosis/diagnose_record.h"
#include "server/auth/secrets.h"
#include "server/course/commitment.h"
#include "server/course/fault_pool.h"
#include "server/course/hints.h"
#include "server/course/kept_events.h"
#include "server/course/trial_witness.h"
#include "server/diagnosis_json/options_json.h"
#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"
#include "server/run/verdict_teller.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

using core::Error;
using core::ErrorCode;

/// As they were when they were taken.
double PaidForHints(const Trial& trial) {
  double percent = 0.0;
  const json::value hints = json::parse(trial.hints);
  for (const json::value& hint : hints.as_array()) {
    const json::value* paid = hint.as_object().if_contains("percent");
    if (paid != nullptr) percent += paid->to_number<double>();
  }
  return percent;
}

/// A run on a simulator begins at once or never.
constexpr std::chrono::minutes kBeginsWithin{2};

/// Of this trial of this person, and of nobody else's.
std::uint64_t SeedOf(const std::string& secret, std::int64_t account, std::size_t former) {
  const std::string hash =
      CommitmentOf(secret, std::to_string(account) + "/" + std::to_string(former));
  return std::stoull(hash.substr(0, 16), nullptr, 16);
}

std::vector<core::Fault> FaultsOf(const Trial& trial, const core::Bench& bench) {
  return FaultsOfPlan(trial.truth, bench);  // a part of a plan, with the same members
}

double SecondsRecorded(const RunRecord& record) {
  return static_cast<double>(record.samples) * record.period_s;
}

/// As the run would have been diagnosed if it had not been sealed.
core::DiagnosisOptions Opened(core::DiagnosisOptions options) {
  const core::DiagnosisOptions usual = core::OptionsOf(*options.bench, options.period_s);
  options.healthy_from_s = usual.healthy_from_s;
  options.healthy_to_s = usual.healthy_to_s;
  return options;
}

/// Those of one sample stay in their order: what the rig did, then what the lab saw of it.
std::vector<RecordedEvent> InOrder(std::vector<RecordedEvent> events,
                                   std::vector<RecordedEvent> more) {
  std::ranges::move(more, std::back_inserter(events));
  std::ranges::stable_sort(events, {}, &RecordedEvent::index);
  return events;
}

std::optional<std::chrono::milliseconds> LimitOf(const Assignment& assignment) {
  const auto rubric = ParseRubric(assignment.rubric_json);
  const std::chrono::duration<double, std::ratio<60>> limit(rubric ? rubric.value().time_limit_min
                                                                   : 0.0);
  if (limit.count() <= 0.0) return std::nullopt;
  return std::chrono::round<std::chrono::milliseconds>(limit);
}

}  // namespace

WallTime BlindTrials::ClosesFor(const Assignment& assignment, std::int64_t account) {
  const auto rubric = ParseRubric(assignment.rubric_json);
  const std::chrono::duration<double, std::ratio<3600>> late(rubric ? rubric.value().late_h : 0.0);
  return assignment.DueFor(account) + std::chrono::round<WallTime::duration>(late);
}

WallTime BlindTrials::AnswerBy(const Assignment& assignment, const Trial& trial) {
  const WallTime closes = ClosesFor(assignment, trial.account);
  const auto limit = LimitOf(assignment);
  return limit ? std::min(closes, trial.created_at + *limit) : closes;
}

core::Result<const core::Bench*> BlindTrials::BenchOf(const Assignment& assignment) {
  return parts_.benches.Find(assignment.bench);
}

core::Result<Trial> BlindTrials::Start(const Principal& who,
                                       const Assignment& assignment,
                                       const std::string& rig,
                                       const json::object* excitation,
                                       bool tries) {
  const WallTime now = parts_.clock.Wall();
  if (now < assignment.opens && !tries) {
    return core::Refuse("assignment_not_open");
  }
  if (now >= ClosesFor(assignment, who.user_id)) {
    return core::Refuse("assignment_closed");
  }
  TRY(const auto bench, BenchOf(assignment));
  TRY(const auto pool, ParsePool(assignment.pool_json, *bench));
  TRY(auto body, ParseJsonObject(assignment.plan_json));
  const bool on_bench = !parts_.experiments.IsForPractice(rig);
  if (assignment.on_bench != on_bench) {
    return assignment.on_bench ? core::Refuse("trial_needs_bench")
                               : core::Refuse("trial_needs_simulator");
  }
  if (!rig.empty()) body["rig"] = rig;
  const bool is_free = body.erase(kFreeExcitation) != 0;
  if (excitation != nullptr && !is_free) {
    return core::Refuse("excitation_fixed");
  }
  if (excitation != nullptr) body["excitation"] = *excitation;
  TRY(auto plan, parts_.experiments.Read(body));
  const auto begin = [&] { return Begin(who, assignment, pool, plan, tries); };
  return on_bench ? begin() : parts_.experiments.InTurn(who, plan, begin);
}

core::Result<Trial> BlindTrials::Begin(const Principal& who,
                                       const Assignment& assignment,
                                       const FaultPool& pool,
                                       ExperimentPlan plan,
                                       bool tries) {
  const WallTime now = parts_.clock.Wall();
  // Of a former one whose server died the attempt is there again.
  TRY(auto mine, parts_.trials.Of(assignment.id, who.user_id, 0, assignment.attempts + 1000));
  for (Trial& each : mine) {
    TRY_DONE(Look(assignment, std::move(each)));
  }
  std::vector<core::Fault> faults;
  const auto draw = [&](const std::vector<Trial>& former, Trial& trial) {
    std::vector<int> had;
    for (const Trial& each : former) had.push_back(each.item);
    faults = Draw(pool, had, SeedOf(assignment.secret, who.user_id, former.size()), &trial.item);
    trial.tried = tries;
    plan.seed = SecretNumber();
    trial.truth =
        json::serialize(json::object{{"faults", server::ToJson(faults)}, {"seed", *plan.seed}});
    Commitment commitment = CommitTo(trial.truth);
    trial.nonce = std::move(commitment.nonce);
    trial.commitment = std::move(commitment.hash);
  };
  TRY(auto trial,
      parts_.trials.Add(
          assignment.id, who.user_id, assignment.attempts, now, LimitOf(assignment), draw));
  const std::int64_t id = trial.id;
  plan.name = assignment.name;
  plan.faults = faults;
  plan.trial = id;
  plan.witness =
      MakeWitness(parts_.trials, id, faults, parts_.ended_by_user, parts_.clock, parts_.log);
  const auto run = parts_.experiments.Start(who, StartedBy::kPerson, std::move(plan));
  if (!run) {
    const core::Status returned = parts_.trials.Forget(id);
    if (!returned.ok()) parts_.log("trial " + std::to_string(id) + ": " + returned.error().message);
    // Why the rig does not play a fault would tell which one was drawn.
    if (run.error().field.starts_with("/faults")) {
      parts_.log("assignment " + std::to_string(assignment.id) + ": " + run.error().message);
      return core::Refuse("trial_not_playable");
    }
    return run.error();
  }
  TRY_DONE(parts_.trials.Began(id, run.value().id));
  return parts_.trials.Get(id);
}

core::Result<Trial> BlindTrials::Look(const Assignment& assignment, Trial trial) {
  const WallTime now = parts_.clock.Wall();
  const char* lost = nullptr;
  // Also when its run has ended, and the database was away when it began: nobody could answer it.
  const bool without_run =
      trial.run.empty() && (trial.state == TrialState::kDrawn || trial.state == TrialState::kOpen);
  if (without_run && now > trial.created_at + kBeginsWithin) {
    lost = "not_begun";
  }
  if (trial.state == TrialState::kRunning) {
    const auto record = parts_.store.Get(trial.run);
    if (!record && record.error().code != ErrorCode::kNotFound) return record.error();
    // Its witness has spoken before its end was stored.
    if (!record || record.value().state != RunState::kRunning) lost = "interrupted";
    TRY(trial, parts_.trials.Get(trial.id));
    if (trial.state != TrialState::kRunning) lost = nullptr;
  }
  if (lost != nullptr) {
    const core::Status done = parts_.trials.Void(trial.id, lost, now);
    if (!done.ok() && done.error().code != ErrorCode::kConflict) return done.error();
    return parts_.trials.Get(trial.id);
  }
  if (trial.state == TrialState::kAnswered && trial.graded_by < assignment.rubric_version) {
    TRY_DONE(GradeAgain(assignment, trial));
    TRY(trial, parts_.trials.Get(trial.id));
  }
  const bool ended = trial.state != TrialState::kDrawn && trial.state != TrialState::kRunning;
  const bool at_once = assignment.reveal_at_once && trial.state == TrialState::kAnswered;
  const WallTime closes = ClosesFor(assignment, trial.account);
  if (!ended || trial.released_at || (!at_once && now < closes)) return trial;
  if (!at_once) {
    TRY(const auto settled, parts_.settled());
    if (settled < closes) return trial;
  }
  TRY_DONE(Release(assignment, trial));
  return parts_.trials.Get(trial.id);
}

core::Status BlindTrials::Look(std::int64_t trial) {
  TRY(auto found, parts_.trials.Get(trial));
  TRY(const auto assignment, parts_.assignments.Get(found.assignment));
  const auto looked = Look(assignment, std::move(found));
  return looked.ok() ? core::Status(core::Done{}) : looked.error();
}

core::Status BlindTrials::Open(const RunRecord& record) {
  const std::vector<std::int64_t> copied = CopiedTrials(record.plan_json);
  if (copied.empty()) return Look(TrialOf(record.plan_json));
  for (const std::int64_t id : copied) {
    TRY(const auto sealed, IsSealedNow(id));
    if (sealed) return core::Done{};
  }
  return parts_.store.Unseal(record.id, "{}", OptionsOfCopy(record.plan_json), {});
}

core::Result<bool> BlindTrials::IsSealedNow(std::int64_t id) {
  const core::Status looked = Look(id);
  if (!looked.ok() && looked.error().code == ErrorCode::kNotFound) return false;
  if (!looked.ok()) return looked.error();
  TRY(const auto trial, parts_.trials.Get(id));
  return !trial.released_at;
}

core::Result<BlindTrials::Seen> BlindTrials::See(RunRecord record) {
  TRY(const auto recording,
      parts_.recordings.Load(std::move(record), 0, kSampleIndexMax, LongTurn::For::kGrading));
  const core::DiagnosisOptions options = Opened(recording.options);
  Seen seen;
  VerdictTeller teller(options.period_s);
  seen.diagnosis = core::DiagnoseRecord(
      recording.samples, options, [&](const core::Verdict& verdict, std::int64_t index) {
        std::ranges::move(teller.Hear(verdict, index), std::back_inserter(seen.events));
      });
  return seen;
}

core::Result<Grade> BlindTrials::GradeOf(const Assignment& assignment,
                                         const Trial& trial,
                                         const Answer& answer,
                                         const core::Diagnosis& diagnosis,
                                         double length_s) {
  TRY(const auto bench, BenchOf(assignment));
  TRY(const auto rubric, ParseRubric(assignment.rubric_json));
  const std::chrono::duration<double, std::ratio<3600>> late =
      trial.answered_at.value_or(parts_.clock.Wall()) - assignment.DueFor(trial.account);
  return GradeAnswer(answer,
                     FaultsOf(trial, *bench),
                     diagnosis,
                     rubric,
                     late.count(),
                     length_s,
                     PaidForHints(trial));
}

/// Of a recording that its owner has deleted, the grade stays.
core::Status BlindTrials::GradeAgain(const Assignment& assignment, const Trial& trial) {
  std::string grade = trial.grade;
  auto record = parts_.store.Get(trial.run);
  if (!record && record.error().code != ErrorCode::kNotFound) return record.error();
  if (record) {
    TRY(const auto bench, BenchOf(assignment));
    TRY(const auto answer, ParseAnswer(trial.answer, *bench));
    const double length_s = SecondsRecorded(record.value());
    TRY(const auto seen, See(std::move(record).value()));
    TRY(const auto graded, GradeOf(assignment, trial, answer, seen.diagnosis, length_s));
    grade = json::serialize(ToJson(graded));
  }
  return parts_.trials.GradeAgain(trial.id, grade, assignment.rubric_version);
}

core::Result<RunRecord> BlindTrials::Answerable(const Assignment& assignment, const Trial& trial) {
  const Error runs = core::Refuse("trial_runs");
  if (trial.state == TrialState::kDrawn || trial.state == TrialState::kRunning) return runs;
  if (trial.state != TrialState::kOpen) {
    return core::Refuse("trial_changed");
  }
  // Whoever has seen the truth answers no more, also when the due time is moved afterwards.
  if (trial.released_at || parts_.clock.Wall() >= AnswerBy(assignment, trial)) {
    return core::Refuse("answer_late");
  }
  TRY(auto record, parts_.store.Get(trial.run));
  if (record.state == RunState::kRunning) return runs;  // its end is being stored
  return record;
}

core::Result<Trial> BlindTrials::TakeHint(const Assignment& assignment,
                                          const Trial& trial,
                                          std::int64_t number) {
  json::value hints = json::parse(trial.hints);
  const int taken = static_cast<int>(hints.as_array().size());
  if (number <= taken) return trial;
  TRY(const auto rubric, ParseRubric(assignment.rubric_json));
  if (rubric.hint_percent <= 0.0) return core::Refuse("no_hints");
  if (number != taken + 1 || taken == kHintsMax) return core::Refuse("hint_not_next");
  TRY(auto record, Answerable(assignment, trial));
  TRY(const auto seen, See(std::move(record)));
  json::object hint = HintOf(taken, seen.diagnosis);
  hint["percent"] = rubric.hint_percent;
  hints.as_array().push_back(std::move(hint));
  TRY_DONE(parts_.trials.TakeHint(trial.id, trial.hints, json::serialize(hints)));
  return parts_.trials.Get(trial.id);
}

core::Result<Trial> BlindTrials::TakeAnswer(const Assignment& assignment,
                                            const Trial& trial,
                                            const Answer& answer) {
  const WallTime now = parts_.clock.Wall();
  TRY(auto record, Answerable(assignment, trial));
  const double length_s = SecondsRecorded(record);
  TRY(const auto seen, See(std::move(record)));
  Trial given = trial;
  given.answered_at = now;
  TRY(const auto grade, GradeOf(assignment, given, answer, seen.diagnosis, length_s));
  TRY_DONE(parts_.trials.Answer(trial.id,
                                trial.hints,
                                json::serialize(ToJson(answer)),
                                json::serialize(ToJson(grade)),
                                assignment.rubric_version,
                                EventsText(InOrder(ParseEvents(trial.events), seen.events)),
                                now));
  TRY(auto answered, parts_.trials.Get(trial.id));
  return Look(assignment, std::move(answered));
}

/// Again after a crash between its two steps: the second time there is nothing to open.
core::Status BlindTrials::Release(const Assignment& assignment, const Trial& trial) {
  TRY_DONE(BenchOf(assignment));
  const auto record = parts_.store.Get(trial.run);
  if (!record && record.error().code != ErrorCode::kNotFound) return record.error();
  if (record && record.value().state == RunState::kRunning) return core::Done{};  // in a moment
  if (record && IsSealed(record.value().plan_json)) {
    TRY(const auto options, parts_.recordings.OptionsFor(record.value()));
    TRY(auto events, parts_.store.LoadEvents(trial.run));
    events = InOrder(std::move(events), ParseEvents(trial.events));
    if (trial.answer.empty()) {  // what the lab saw is kept with an answer
      TRY(auto seen, See(record.value()));
      events = InOrder(std::move(events), std::move(seen.events));
    }
    TRY_DONE(parts_.store.Unseal(trial.run,
                                 OpenedPlan(record.value().plan_json, trial.truth),
                                 OptionsText(Opened(options)),
                                 events));
  }
  const core::Status released = parts_.trials.Release(trial.id, parts_.clock.Wall());
  if (!released.ok() && released.error().code != ErrorCode::kConflict) return released;
  return core::Done{};
}

}  // namespace faultlab::server::course
