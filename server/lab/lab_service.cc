#include "server/lab/lab_service.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/storage/ids.h"

namespace faultlab::server::lab {
namespace {

/// Smaller differences between the clocks are drift; larger ones mean that the clock was set.
constexpr Milliseconds kJump{2000};
/// A step of the clock that is not taken back for so long is right.
constexpr Milliseconds kBelieved = std::chrono::minutes(5);
constexpr std::size_t kRequestsMax = 10'000;
/// Requests in one turn: computing them in the transaction must take less than 750 ms, after which
/// the database treats this process as frozen.
constexpr std::ptrdiff_t kRequestsOfATurn = 50;
constexpr Milliseconds kLeaseAlone = std::chrono::hours(24);
constexpr Milliseconds kJoinLook{250};
constexpr const char* kMemberField = "server_id";
/// Longest time from the lease of a practice run until it holds the simulator: Acquire waits 5 s at
/// most.
constexpr Milliseconds kPracticeBegins = std::chrono::seconds(30);
constexpr Milliseconds kLostRunLook = std::chrono::seconds(10);
/// Longest time in which a run may store its last diagnosis and its end after its rig was passed
/// on.
constexpr Milliseconds kLastWords = std::chrono::minutes(2);

std::vector<LabEvent> ToEvents(const std::vector<Notice>& notices, WallTime now) {
  std::vector<LabEvent> events;
  for (const Notice& notice : notices) {
    events.push_back({0,
                      notice.user,
                      now,
                      notice.topic,
                      notice.text,
                      notice.session,
                      notice.rig,
                      notice.other,
                      notice.why,
                      notice.reason,
                      notice.time,
                      {}});
  }
  return events;
}

std::vector<Rig> AllRigs(const LabState& state) {
  std::vector<Rig> rigs;
  for (const auto& [id, rig] : state.rigs) rigs.push_back(rig);
  return rigs;
}

}  // namespace

LabService::LabService(std::unique_ptr<LabStore> store,
                       const Clock& clock,
                       RigDuties& duties,
                       LabServiceOptions options)
    : store_(std::move(store)),
      clock_(clock),
      duties_(duties),
      options_(std::move(options)),
      scheduler_(options_.policy),
      last_wall_(clock.Wall()),
      last_monotonic_(clock.Monotonic()),
      boot_(NewId("boot")) {}

core::Result<std::unique_ptr<LabService>> LabService::Open(Database& database,
                                                           const Clock& clock,
                                                           RigDuties& duties,
                                                           LabServiceOptions options) {
  return Open(std::make_unique<DatabaseLabStore>(database), clock, duties, std::move(options));
}

core::Result<std::unique_ptr<LabService>> LabService::Open(std::unique_ptr<LabStore> store,
                                                           const Clock& clock,
                                                           RigDuties& duties,
                                                           LabServiceOptions options) {
  auto service = std::unique_ptr<LabService>(
      new LabService(std::move(store), clock, duties, std::move(options)));
  // A previous process with this id that has just died keeps its place until its lease ends.
  const auto give_up = std::chrono::steady_clock::now() + service->options_.join_patience;
  std::deque<Request> none;
  core::Status loaded = service->Transact(none, Entry::kJoins);
  while (!loaded.ok() && loaded.error().field == kMemberField &&
         std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(kJoinLook);
    loaded = service->Transact(none, Entry::kJoins);
  }
  if (!loaded.ok()) return loaded.error();
  service->StartChecks();
  if (!service->options_.own_thread) return service;
  service->thread_ = std::thread([raw = service.get()] { raw->Main(); });
  return service;
}

LabService::~LabService() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (!thread_.joinable()) return;
  thread_.join();
  if (!options_.alone) return;  // the others notice it
  (void)store_->Write([this](LabTurn& turn) -> core::Status {
    turn.StoodStill(clock_.Wall());
    return core::Done{};
  });
}

core::Status LabService::Submit(Input input) {
  if (!options_.own_thread) {
    std::deque<Request> one;
    one.push_back({std::move(input), {}});
    std::future<core::Status> stored = one.front().stored.get_future();
    Turn(std::move(one));
    return stored.get();
  }
  std::future<core::Status> stored;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_)
      return core::Error{core::ErrorCode::kUnavailable, "the server stops", "", "server_stops"};
    if (requests_.size() >= kRequestsMax) {
      return core::Error{
          core::ErrorCode::kBusy, "too many requests at once; try again", "", "lab_busy"};
    }
    requests_.push_back({std::move(input), {}});
    stored = requests_.back().stored.get_future();
  }
  wake_.notify_one();
  return stored.get();
}

core::Status LabService::TickNow() {
  return Submit([](Scheduler& scheduler, WallTime now) { scheduler.Tick(now); });
}

core::Status LabService::CleaningDone(const RigId& rig,
                                      std::uint64_t epoch,
                                      bool passed,
                                      const std::string& detail) {
  return Do([&](Scheduler& scheduler, WallTime now) {
    return scheduler.CleaningDone(rig, epoch, passed, detail, now);
  });
}

std::shared_ptr<const LabState> LabService::state() const {
  const std::lock_guard lock(mutex_);
  return published_;
}

Policy LabService::policy() const {
  Policy policy = options_.policy;
  const auto now = state();
  if (now->settings) static_cast<PolicySettings&>(policy) = *now->settings;
  return policy;
}

core::Result<std::vector<LabEvent>> LabService::EventsSince(UserId user,
                                                            std::int64_t since,
                                                            int limit) {
  return store_->EventsSince(user, since, limit);
}

std::optional<Member> LabService::MemberOf(const RigId& rig) const {
  const std::lock_guard lock(mutex_);
  const auto found = published_->rigs.find(rig);
  if (found == published_->rigs.end()) return std::nullopt;
  for (const Member& member : members_) {
    if (member.id == found->second.server) return member;
  }
  return std::nullopt;
}

std::optional<Member> LabService::MemberWithId(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  for (const Member& member : members_) {
    if (member.id == id) return member;
  }
  return std::nullopt;
}

std::vector<Member> LabService::Others() const {
  const std::lock_guard lock(mutex_);
  std::vector<Member> others = members_;
  std::erase_if(others, [this](const Member& each) { return each.id == options_.member; });
  return others;
}

std::string LabService::boot() const {
  const std::lock_guard lock(mutex_);
  return boot_;
}

void LabService::Main() {
  while (true) {
    std::deque<Request> requests;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, options_.tick, [&] { return stopping_ || !requests_.empty(); });
      const auto end = requests_.begin() + std::min(std::ssize(requests_), kRequestsOfATurn);
      requests.assign(std::move_iterator(requests_.begin()), std::move_iterator(end));
      requests_.erase(requests_.begin(), end);
      if (stopping_ && requests.empty()) return;
    }
    Turn(std::move(requests));
  }
}

void LabService::Turn(std::deque<Request> requests) {
  const core::Status stored = Transact(requests, Entry::kStays);
  for (Request& request : requests) request.stored.set_value(stored);
  if (stored.ok()) StartChecks();  // otherwise the result of a check could not be stored
}

void LabService::NoticeClockJump() {
  const WallTime wall = clock_.Wall();
  const MonotonicTime monotonic = clock_.Monotonic();
  const auto passed = std::chrono::duration_cast<Milliseconds>(
      monotonic - std::exchange(last_monotonic_, monotonic));
  const Milliseconds jump = wall - std::exchange(last_wall_, wall) - passed;
  // Each server that shares the database would apply the same shift again; there NTP must keep the
  // clocks of the machines.
  if (store_->shared() || (jump <= kJump && jump >= -kJump)) return;
  const Milliseconds unbelieved = Milliseconds(unbelieved_ms_.load()) + jump;
  const bool set_back = unbelieved <= kJump && unbelieved >= -kJump;
  unbelieved_ms_ = set_back ? 0 : unbelieved.count();
  jumped_at_ = monotonic;
}

bool LabService::BelievesClock() const {
  return unbelieved_ms_.load() != 0 && last_monotonic_ - jumped_at_ >= kBelieved;
}

/// A practice session exists only for its run. If the end of the run was not noticed (the database
/// was away), the session ends here.
void LabService::NoticeRuns(Scheduler& next, WallTime now) {
  std::vector<std::pair<SessionId, bool>> changed;
  std::vector<SessionId> left;
  for (const auto& [id, session] : next.state().sessions) {
    if (session.state != SessionState::kActive) continue;
    if (!IsOwn(next.state().rigs.at(session.rig))) continue;
    const bool running = duties_.RunInProgress(session.rig);
    if (session.kind != TicketKind::kPractice) {
      if (running != session.run_in_progress) changed.emplace_back(id, running);
    } else if (!running && now - session.start > kPracticeBegins) {
      left.push_back(id);
    }
  }
  for (const SessionId id : left) next.EndPractice(id, now);
  for (const auto& [id, running] : changed) {
    // Neither call refuses an active session.
    (void)(running ? next.RunStarted(id, now) : next.RunEnded(id, now));
  }
}

Milliseconds LabService::ClockOffset() const {
  return std::chrono::duration_cast<Milliseconds>(clock_.Wall().time_since_epoch() -
                                                  clock_.Monotonic().time_since_epoch());
}

/// Every member judges the leases, bookings and waits of all members by its own clock.
core::Status LabService::CheckClock(LabTurn& turn) {
  const Milliseconds limit = options_.clock_error_max;
  if (limit == Milliseconds{0} || !store_->shared()) return core::Done{};
  const WallTime asked = clock_.Wall();
  const WallTime theirs = turn.StoreTime();
  const Milliseconds error = asked + (clock_.Wall() - asked) / 2 - theirs;
  if (error <= limit && error >= -limit) {
    checked_offset_ = ClockOffset();
    return core::Done{};
  }
  return core::Error{core::ErrorCode::kUnavailable,
                     "this machine's clock is " + std::to_string(error.count()) +
                         " ms off the database's, and servers may differ by " +
                         std::to_string(limit.count()) + " ms; keep it by NTP",
                     "",
                     "clock_off"};
}

/// After an outage of the database every lease has ended: each member gets the time of one lease to
/// come back before the others may remove it.
bool LabService::MayRemove() {
  const MonotonicTime now = clock_.Monotonic();
  const Milliseconds lease = options_.policy.member_lease;
  if (now - last_turn_ > lease / 2) remove_from_ = now + lease;
  last_turn_ = now;
  return now >= remove_from_;
}

/// A run stores its own end; if that failed, the run would stay `running` for ever.
void LabService::InterruptLostRuns(LabTurn& turn, WallTime now) {
  const MonotonicTime looked = clock_.Monotonic();
  if (looked - last_look_ < kLostRunLook) return;
  last_look_ = looked;
  std::map<std::string, MonotonicTime> past;
  for (const std::string& run : turn.RunsOfPastLeases(options_.member, now)) {
    const auto known = past_runs_.find(run);
    const MonotonicTime since = known == past_runs_.end() ? looked : known->second;
    if (looked - since < kLastWords) {
      past.emplace(run, since);
    } else {
      turn.InterruptRun(run, now);
    }
  }
  past_runs_ = std::move(past);
}

/// The membership of this process: taken at the start, renewed at each turn, and taken again when
/// the others have removed this member because it was frozen. Members whose leases have ended are
/// removed.
core::Status LabService::KeepMembership(LabTurn& turn, Scheduler& next, Entry entry, WallTime now) {
  std::vector<Member> all = turn.Members();
  WallTime somebody_until{};
  for (const Member& each : all) somebody_until = std::max(somebody_until, each.lease_until);
  if (!all.empty() && somebody_until < now) {
    next.StoodStill(now - somebody_until);
    turn.StoodStill(somebody_until);
    use_unknown_ = true;
  }
  auto self = std::find_if(
      all.begin(), all.end(), [&](const Member& each) { return each.id == options_.member; });
  const bool ours = self != all.end() && self->boot == boot_;
  if (!ours) {
    const bool alive =
        self != all.end() && self->lease_until > now && !(entry == Entry::kJoins && options_.alone);
    if (alive) {
      return core::Error{core::ErrorCode::kConflict,
                         "another server with server_id '" + options_.member +
                             "' uses this database; give each server an id of its own",
                         kMemberField,
                         "internal"};
    }
    if (entry == Entry::kStays) {
      next.MemberGone(options_.member, now);  // its former rigs were given up in the meantime
      const std::lock_guard lock(mutex_);
      boot_ = NewId("boot");  // what the past membership has claimed is not claimed by this one
    }
    turn.InterruptRunsOf(options_.member, now);  // runs of the previous process
    if (self == all.end()) self = all.insert(all.end(), Member{});
    *self = {options_.member, boot_, options_.address, WallTime{}};
  }
  // A busy machine may lose half of a lease.
  const Milliseconds lease = options_.alone ? kLeaseAlone : options_.policy.member_lease;
  const bool renews = self->lease_until < now + lease / 2;
  const Milliseconds moved = ClockOffset() - checked_offset_;
  const Milliseconds unnoticed = options_.clock_error_max / 2;
  if (renews || moved > unnoticed || moved < -unnoticed) {
    const core::Status clock = CheckClock(turn);
    if (!clock.ok()) return clock;
  }
  if (renews) {
    self->lease_until = now + lease;
    turn.PutMember(*self);
  }
  member_until_ = self->lease_until;
  const bool may_remove = MayRemove();
  for (auto each = all.begin(); each != all.end();) {
    if (each->id == options_.member || each->lease_until > now || !may_remove) {
      ++each;
      continue;
    }
    next.MemberGone(each->id, now);
    turn.RemoveMember(each->id, now);
    each = all.erase(each);
  }
  const std::lock_guard lock(mutex_);
  members_ = std::move(all);
  return core::Done{};
}

core::Status LabService::Transact(std::deque<Request>& requests, Entry entry) {
  std::optional<Scheduler> next;
  std::int64_t version = 0;
  MonotonicTime looked{};
  WallTime now{};
  bool believes = false;
  const core::Status stored = store_->Write([&](LabTurn& turn) -> core::Status {
    version = turn.LockVersion();
    next.emplace(version == version_ ? scheduler_ : Scheduler(options_.policy, turn.Load()));
    // The turn that followed a step of the clock was stored, although its answer was lost.
    if (shifted_version_ >= 0 && version >= shifted_version_) unbelieved_ms_ = 0;
    shifted_version_ = -1;
    NoticeClockJump();
    looked = clock_.Monotonic();
    believes = BelievesClock();
    now = believes ? clock_.Wall() : Now();
    if (believes) {
      next->ClockJumped(Milliseconds(unbelieved_ms_.load()), now);
      shifted_version_ = version + 1;
    }
    const core::Status member = KeepMembership(turn, *next, entry, now);
    if (!member.ok()) return member;
    if (entry == Entry::kJoins) next->Recover(now, options_.member);
    InterruptLostRuns(turn, now);
    NoticeRuns(*next, now);
    for (Request& request : requests) request.input(*next, now);
    next->Tick(now);
    const std::vector<LabEvent> events = ToEvents(next->TakeNotices(), now);
    const Changes changes = next->TakeChanges();
    if (entry == Entry::kJoins || std::exchange(use_unknown_, false)) {
      turn.NoteUse(next->state(), AllRigs(next->state()), now);
    }
    if (changes.empty() && events.empty()) return core::Done{};
    turn.Save(changes, ++version);
    turn.NoteUse(next->state(), changes.rigs, now);
    turn.AddEvents(events);
    return core::Done{};
  });
  if (!stored.ok()) {
    version_ = -1;            // after a failure the next turn loads the state from the disk
    checked_epochs_.clear();  // its result may be lost, so the check is repeated
    const bool replaced = entry == Entry::kStays && stored.error().field == kMemberField;
    if (replaced) FenceForReplacement(next->state());
    return stored;
  }
  if (believes) unbelieved_ms_ = 0;
  shifted_version_ = -1;
  in_force_until_ = looked + (member_until_ - now);
  // Fence before any answer is sent: a run or a command of an older epoch must not continue after
  // it.
  FenceRigs(next->state());
  Publish(std::move(*next), version);
  return stored;
}

bool LabService::InForce() const {
  return options_.alone || clock_.Monotonic() < in_force_until_.load();
}

/// A rig that this server had before is fenced too: after being frozen, this server may still run
/// what the others have ended.
void LabService::FenceRigs(const LabState& state) {
  for (const auto& [id, rig] : state.rigs) {
    if (!IsOwn(rig) && !fenced_epochs_.contains(id)) continue;
    std::uint64_t& fenced = fenced_epochs_[id];
    if (rig.epoch == fenced) continue;
    fenced = rig.epoch;
    duties_.Fence(id, rig.epoch);
  }
}

/// A new process has taken this member's place and may use the same epochs that this process knows.
/// Therefore this process accepts only epochs from the next one on.
void LabService::FenceForReplacement(const LabState& state) {
  for (auto& [id, fenced] : fenced_epochs_) {
    const auto rig = state.rigs.find(id);
    const std::uint64_t next = (rig == state.rigs.end() ? fenced : rig->second.epoch) + 1;
    if (next <= fenced) continue;
    fenced = next;
    duties_.Fence(id, next);
  }
}

void LabService::Publish(Scheduler next, std::int64_t version) {
  const bool moved = version != published_version_;
  scheduler_ = std::move(next);
  version_ = published_version_ = version;
  auto snapshot = std::make_shared<const LabState>(scheduler_.state());
  {
    const std::lock_guard lock(mutex_);
    published_ = std::move(snapshot);
  }
  if (moved && options_.changed) options_.changed();
}

/// Checks follow from the stored state, whoever changed it. Therefore they survive a crash, and a
/// server checks its own rigs when another one ended the session.
void LabService::StartChecks() {
  for (const auto& [id, rig] : scheduler_.state().rigs) {
    if (rig.status != RigStatus::kCleaning || !IsOwn(rig)) continue;
    std::uint64_t& checked = checked_epochs_[id];
    if (rig.epoch == checked) continue;
    checked = rig.epoch;
    duties_.StartCleaning({id, {}, rig.epoch, {}, rig.cleaning_due});
  }
}

}  // namespace faultlab::server::lab
