#include "server/lab/lab_service.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/storage/ids.h"

namespace faultlab::server::lab {
namespace {

constexpr std::size_t kRequestsMax = 10'000;
/// Requests in one turn: computing them in the transaction must take less than 750 ms, after which
/// the database treats this process as frozen.
constexpr std::ptrdiff_t kRequestsOfATurn = 50;
constexpr Milliseconds kJoinLook{250};
/// Longest time from the lease of a practice run until it holds the simulator: Acquire waits 5 s at
/// most.
constexpr Milliseconds kPracticeBegins = std::chrono::seconds(30);

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
    if (stopping_) return core::Refuse("server_stops");
    if (requests_.size() >= kRequestsMax) {
      return core::Refuse("lab_busy");
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
  const auto changed = now->settings.find("");
  if (changed != now->settings.end()) static_cast<PolicySettings&>(policy) = changed->second;
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
    TRY_DONE(KeepMembership(turn, *next, entry, now));
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
