#include "server/app/job_runner.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>
#include <variant>

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

/// A job that found no rig is tried again after this time; other jobs have their turn meanwhile.
constexpr seconds kNextTry{1};
/// While so many of an owner's jobs have found no rig, or the turn taken, no other of that kind is
/// claimed.
constexpr int kPutOffOfOwnerMax = 4;
/// What happens at other members rings no bell here: their jobs, and cancelled ones.
constexpr seconds kLookAtOthers{1};
/// Time for arming, the first sample and the end of the recording, in addition to the run itself.
constexpr milliseconds kMargin = seconds(30);

/// What this thread does, and the threads that it begins, has a tenth of the turns that a person's
/// run in real time has, where both want the core (PacedRig asks for the rest). SCHED_IDLE would be
/// less than whatever else the machine does.
void StepBack() {
  constexpr int kNiceness = 10;
  constexpr id_t kThisThread = 0;
  setpriority(PRIO_PROCESS, kThisThread, kNiceness);
}

bool HasTicket(const lab::LabState& state, const std::string& job) {
  return std::ranges::any_of(state.tickets, [&](const auto& entry) {
    return entry.second.kind == lab::TicketKind::kJob && entry.second.job == job;
  });
}

/// Of this owner on this rig, so many jobs ask at the same time: more could not begin.
int AskingAtOnce(const lab::LabState& state, const std::string& rig_class) {
  return static_cast<int>(std::ranges::count_if(
      state.rigs, [&](const auto& entry) { return entry.second.rig_class == rig_class; }));
}

}  // namespace

const lab::Session* JobRunner::SessionOf(const lab::LabState& state, const std::string& job) {
  for (const auto& [id, session] : state.sessions) {
    const bool runs = session.kind == lab::TicketKind::kJob && session.job == job;
    if (runs && session.state != lab::SessionState::kClosed) return &session;
  }
  return nullptr;
}

JobRunner::JobRunner(Parts parts, Options options) : parts_(parts), options_(std::move(options)) {
  thread_ = std::thread([this] { Main(); });
}

JobRunner::~JobRunner() {
  Stop();
}

void JobRunner::Stop() {
  std::vector<std::string> runs;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (const InProgress& it : in_progress_) {
      if (!it.run.empty()) runs.push_back(it.run);
    }
  }
  parts_.bell.Ring();
  for (const std::string& run : runs) (void)parts_.runs.Stop(run, kServerStops);
  if (thread_.joinable()) thread_.join();
  for (InProgress& it : in_progress_) it.thread.join();
  in_progress_.clear();
}

bool JobRunner::stopping() const {
  const std::lock_guard lock(mutex_);
  return stopping_;
}

void JobRunner::Main() {
  while (!stopping()) {
    retry_ = false;
    Look();
    parts_.bell.Await(NextLook());
  }
}

void JobRunner::Look() {
  JoinEnded();
  Reap();
  StopLost();
  const Rigs rigs = RigsNow();
  if (!rigs.ask_for.empty()) AskForBenches(rigs);
  BeginOnBenches();
  BeginInPlaces(rigs);
}

/// Durations by the steady clock: no step of the wall clock makes a job wait.
std::optional<JobRunner::Steady> JobRunner::NextLook() {
  const Steady now = steady_clock::now();
  std::optional<Steady> next;
  if (retry_ || !parts_.service.Others().empty()) next = now + kLookAtOthers;
  const std::lock_guard lock(mutex_);
  for (const auto& [job, again] : put_off_) next = next ? std::min(*next, again.at) : again.at;
  return next;
}

/// Jobs of members that are gone, and of this server's process before this one.
void JobRunner::Reap() {
  const Steady now = steady_clock::now();
  if (now - reaped_ < kLookAtOthers) {
    retry_ = true;
    return;
  }
  const auto reaped = parts_.jobs.Reap(parts_.clock.Wall());
  Log(reaped);
  retry_ = retry_ || !reaped.ok();
  reaped_ = now;
}

void JobRunner::JoinEnded() {
  const std::lock_guard lock(mutex_);
  for (auto it = in_progress_.begin(); it != in_progress_.end();) {
    if (!it->ended) {
      ++it;
      continue;
    }
    it->thread.join();  // it only has to return
    it = in_progress_.erase(it);
  }
  std::erase_if(put_off_,
                [now = steady_clock::now()](const auto& each) { return each.second.at <= now; });
}

/// Stops the runs of jobs that were cancelled at another member, or that this server lost while it
/// was frozen.
void JobRunner::StopLost() {
  if (parts_.service.Others().empty()) return;
  std::vector<std::pair<std::string, std::string>> running;  // job, run
  {
    const std::lock_guard lock(mutex_);
    for (const InProgress& it : in_progress_) {
      if (!it.run.empty() && !it.over && !it.ended) running.emplace_back(it.job.id, it.run);
    }
  }
  if (running.empty()) return;
  const auto held = parts_.jobs.HeldBy({parts_.service.member(), parts_.service.boot()});
  Log(held);
  if (!held.ok()) return;
  for (const auto& [job, run] : running) {
    if (std::ranges::find(held.value(), job) != held.value().end()) continue;
    (void)parts_.runs.Stop(run, "its job is over");
  }
}

JobRunner::Rigs JobRunner::RigsNow() const {
  Rigs rigs;
  const std::string& own = parts_.service.member();
  const auto state = parts_.service.state();
  for (const auto& [id, rig] : state->rigs) {
    const auto member = parts_.service.MemberOf(id);
    const bool others = member && member->id != own;
    if (!rig.elastic && !others) rigs.ask_for.push_back(id);
    if (!rig.elastic || others) rigs.not_without.push_back(id);
  }
  return rigs;
}

core::Result<lab::TicketRequest> JobRunner::TicketFor(const Job& job, const lab::LabState& state) {
  TRY(const auto work, parts_.experiments.ReadWork(std::string_view(job.body)));
  const auto& plan = std::get<ExperimentPlan>(work);  // a diagnosis names no rig
  lab::TicketRequest request;
  request.user = lab::UserId{job.account_id};
  request.rig_class = state.rigs.at(job.rig).rig_class;
  request.kind = lab::TicketKind::kJob;
  request.job = job.id;
  TRY(request.courses, parts_.accounts.CoursesOf(job.account_id));
  request.weight = parts_.service.policy().job_weight_s;
  request.min = request.want =
      std::chrono::ceil<milliseconds>(std::chrono::duration<double>(plan.duration_s)) + kMargin;
  return request;
}

/// The jobs that wait for a bench have places in its queue; nothing else is held for them.
void JobRunner::AskForBenches(const Rigs& rigs) {
  const auto state = parts_.service.state();
  int at_once = 0;
  for (const std::string& rig : rigs.ask_for) {
    at_once = std::max(at_once, AskingAtOnce(*state, state->rigs.at(rig).rig_class));
  }
  const auto waiting = parts_.jobs.WaitingOn(rigs.ask_for, at_once);
  Log(waiting);
  if (!waiting.ok()) {
    retry_ = true;
    return;
  }
  for (const Job& job : waiting.value()) {
    if (HasTicket(*state, job.id) || SessionOf(*state, job.id) != nullptr) continue;
    if (IsPutOff(job.id)) continue;
    const auto request = TicketFor(job, *state);
    core::Status asked = core::Done{};
    if (request.ok()) {
      const auto answer = parts_.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
        return scheduler.RequestTicket(request.value(), now);
      });
      if (!answer.ok()) asked = answer.error();
    } else {
      asked = request.error();
    }
    if (asked.ok()) {
      // It may have been cancelled since the list was read, when it had no place to be taken from.
      const auto now = parts_.jobs.Get(job.id);
      if (now.ok() && now.value().ended_at) Drop(job.id);
      continue;
    }
    const core::ErrorCode code = asked.error().code;
    if (code == core::ErrorCode::kBusy || code == core::ErrorCode::kUnavailable) {
      PutOff(job, Needs::kBench);
      continue;
    }
    const auto claimed = parts_.jobs.ClaimThis(
        {parts_.service.member(), parts_.service.boot()}, job.id, parts_.clock.Wall());
    Log(claimed);
    if (claimed.ok() && claimed.value()) {
      Finish(*claimed.value(), "failed", asked.error().message);
    }
  }
}

/// A job whose session has begun on a rig of this server begins at once: it needs no place.
void JobRunner::BeginOnBenches() {
  const auto state = parts_.service.state();
  for (const auto& [id, session] : state->sessions) {
    const bool ours = session.kind == lab::TicketKind::kJob &&
                      session.state == lab::SessionState::kActive &&
                      state->rigs.at(session.rig).server == parts_.service.member();
    if (!ours || IsPutOff(session.job)) continue;
    {
      const std::lock_guard lock(mutex_);
      const bool begun = std::ranges::any_of(
          in_progress_,
          [&, &session = session](const InProgress& it) { return it.job.id == session.job; });
      if (begun) continue;
    }
    auto claimed = parts_.jobs.ClaimThis(
        {parts_.service.member(), parts_.service.boot()}, session.job, parts_.clock.Wall());
    Log(claimed);
    if (!claimed.ok()) {
      retry_ = true;
    } else if (claimed.value()) {
      Begin(std::move(*claimed.value()), session.rig);
    } else if (const auto job = parts_.jobs.Get(session.job);
               !job.ok() || job.value().ended_at.has_value()) {
      Drop(session.job);
    }
  }
}

/// What has no place, and whose share is used.
JobsLeftOut JobRunner::LeftOut(const Rigs& rigs) {
  const bool turn_is_taken = parts_.recordings.long_turn().IsTaken(LongTurn::For::kJob);
  const std::lock_guard lock(mutex_);
  JobsLeftOut out{rigs.not_without, {}, {}};
  JobPlaces taken{0, 0};
  std::map<std::string, JobPlaces> of;
  for (const InProgress& it : in_progress_) {
    if (!it.bench.empty() || it.ended) continue;
    const auto place = it.job.recording.empty() ? &JobPlaces::runs : &JobPlaces::computing;
    ++(taken.*place);
    ++(of.try_emplace(it.job.owner, JobPlaces{0, 0}).first->second.*place);
  }
  const JobPlaces& all = options_.places;
  out.kinds = {taken.runs >= all.runs, taken.computing >= all.computing};
  for (const auto& [owner, has] : of) {
    out.of[owner].kinds = {has.runs >= JobPlaces::ShareOf(all.runs),
                           has.computing >= JobPlaces::ShareOf(all.computing)};
  }
  std::map<std::string, JobPlaces> put_off;
  for (const auto& [job, again] : put_off_) {
    out.of[again.owner].ids.push_back(job);
    if (again.needs == Needs::kAnyRig)
      ++put_off.try_emplace(again.owner, JobPlaces{0, 0}).first->second.runs;
  }
  if (!turn_is_taken) await_turn_.clear();
  for (const auto& [job, owner] : await_turn_) {
    out.of[owner].ids.push_back(job);
    ++put_off.try_emplace(owner, JobPlaces{0, 0}).first->second.computing;
  }
  for (const auto& [owner, count] : put_off) {
    JobsLeftOut::Kinds& kinds = out.of[owner].kinds;
    kinds.runs = kinds.runs || count.runs >= kPutOffOfOwnerMax;
    kinds.computing = kinds.computing || count.computing >= kPutOffOfOwnerMax;
  }
  for (const std::string& owner : gave_way_) out.of[owner].kinds.computing = true;
  return out;
}

void JobRunner::BeginInPlaces(const Rigs& rigs) {
  while (!stopping()) {
    const JobsLeftOut left_out = LeftOut(rigs);
    if (left_out.kinds.runs && left_out.kinds.computing) return;
    auto claimed = parts_.jobs.Claim(
        {parts_.service.member(), parts_.service.boot()}, left_out, parts_.clock.Wall());
    Log(claimed);
    retry_ = retry_ || !claimed.ok();
    if (!claimed.ok()) return;
    const bool computes = claimed.value() && !claimed.value()->recording.empty();
    if (claimed.value()) Begin(std::move(*claimed.value()), "");
    const std::lock_guard lock(mutex_);
    if (claimed.value() && !(computes && !gave_way_.empty())) continue;
    if (gave_way_.empty()) return;
    gave_way_.clear();
    if (!claimed.value()) continue;
    // For whom they gave way has begun; it takes the turn before they are tried again.
    retry_ = true;
    return;
  }
}

void JobRunner::Begin(Job job, std::string bench) {
  const std::lock_guard lock(mutex_);
  InProgress& it = in_progress_.emplace_back();
  it.job = std::move(job);
  it.bench = std::move(bench);
  it.thread = std::thread([this, &it] {
    // A run on a bench keeps its time.
    if (it.bench.empty()) StepBack();
    Do(it);
    {
      const std::lock_guard inner(mutex_);
      it.ended = true;
    }
    parts_.bell.Ring();
  });
}

bool JobRunner::IsPutOff(const std::string& job) const {
  const std::lock_guard lock(mutex_);
  const auto found = put_off_.find(job);
  return found != put_off_.end() && steady_clock::now() < found->second.at;
}

void JobRunner::PutOff(const Job& job, Needs needs) {
  const std::lock_guard lock(mutex_);
  put_off_[job.id] = {job.owner, steady_clock::now() + kNextTry, needs};
}

void JobRunner::Drop(const std::string& job) {
  Log(parts_.service.Do(
      [&](lab::Scheduler& scheduler, WallTime now) { return scheduler.DropJob(job, now); }));
}

}  // namespace faultlab::server
