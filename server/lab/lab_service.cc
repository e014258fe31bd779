#include "server/lab/lab_service.h"

#include <utility>

namespace faultlab::server::lab {
namespace {

/// Smaller differences between the clocks are drift, not somebody setting the time.
constexpr Milliseconds kJump{2000};
constexpr std::size_t kRequestsMax = 10'000;

std::vector<LabEvent> ToEvents(const std::vector<Notice>& notices, WallTime now) {
  std::vector<LabEvent> events;
  for (const Notice& notice : notices) {
    events.push_back({0, notice.user, now, notice.topic, notice.text, notice.session});
  }
  return events;
}

}  // namespace

LabService::LabService(Database& database,
                       const Clock& clock,
                       RigDuties& duties,
                       LabServiceOptions options)
    : database_(database),
      clock_(clock),
      duties_(duties),
      options_(std::move(options)),
      scheduler_(options_.policy),
      last_wall_(clock.Wall()),
      last_monotonic_(clock.Monotonic()),
      own_rigs_(options_.own_rigs) {}

core::Result<std::unique_ptr<LabService>> LabService::Open(Database& database,
                                                           const Clock& clock,
                                                           RigDuties& duties,
                                                           LabServiceOptions options) {
  auto service =
      std::unique_ptr<LabService>(new LabService(database, clock, duties, std::move(options)));
  std::deque<Request> none;
  const core::Status loaded = service->Transact(none, /*recover=*/true);
  if (!loaded.ok()) return loaded.error();
  service->StartChecks();
  service->thread_ = std::thread([raw = service.get()] { raw->Main(); });
  return service;
}

LabService::~LabService() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

core::Status LabService::Submit(Input input) {
  std::future<core::Status> stored;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return core::Error{core::ErrorCode::kUnavailable, "the server stops", ""};
    if (requests_.size() >= kRequestsMax) {
      return core::Error{core::ErrorCode::kBusy, "too many requests at once; try again", ""};
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

core::Result<std::vector<LabEvent>> LabService::EventsSince(UserId user,
                                                            std::int64_t since,
                                                            int limit) {
  using Events = std::vector<LabEvent>;
  return database_.Read([&](Transaction& tx) -> core::Result<Events> {
    return lab_store::EventsSince(tx, user, since, limit);
  });
}

void LabService::Own(const RigId& rig) {
  const std::lock_guard lock(mutex_);
  own_rigs_.insert(rig);
}

std::set<RigId> LabService::own_rigs() const {
  const std::lock_guard lock(mutex_);
  return own_rigs_;
}

void LabService::Main() {
  while (true) {
    std::deque<Request> requests;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, options_.tick, [&] { return stopping_ || !requests_.empty(); });
      requests.swap(requests_);
      if (stopping_ && requests.empty()) return;
    }
    Turn(std::move(requests));
  }
}

void LabService::Turn(std::deque<Request> requests) {
  const core::Status stored = Transact(requests, /*recover=*/false);
  for (Request& request : requests) request.stored.set_value(stored);
  StartChecks();
}

void LabService::NoticeClockJump(Scheduler& next) {
  const WallTime wall = clock_.Wall();
  const MonotonicTime monotonic = clock_.Monotonic();
  const auto passed = std::chrono::duration_cast<Milliseconds>(
      monotonic - std::exchange(last_monotonic_, monotonic));
  const Milliseconds jump = wall - std::exchange(last_wall_, wall) - passed;
  // Servers that share a database would each shift what the other has shifted: there the machines'
  // clocks are kept by NTP.
  if (database_.engine() == Engine::kPostgresql) return;
  if (jump > kJump || jump < -kJump) next.ClockJumped(jump);
}

void LabService::NoticeRuns(Scheduler& next, WallTime now) {
  const std::set<RigId> own = own_rigs();
  std::vector<std::pair<SessionId, bool>> changed;
  for (const auto& [id, session] : next.state().sessions) {
    const bool person = session.kind != TicketKind::kPractice;  // which is nothing but its run
    if (session.state != SessionState::kActive || !person || !own.contains(session.rig)) continue;
    const bool running = duties_.RunInProgress(session.rig);
    if (running != session.run_in_progress) changed.emplace_back(id, running);
  }
  for (const auto& [id, running] : changed) {
    (void)(running ? next.RunStarted(id, now) : next.RunEnded(id, now));
  }
}

core::Status LabService::Transact(std::deque<Request>& requests, bool recover) {
  std::optional<Scheduler> next;
  std::int64_t version = 0;
  const core::Status stored =
      database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
        version = lab_store::LockVersion(tx);
        next.emplace(version == version_ ? scheduler_
                                         : Scheduler(options_.policy, lab_store::Load(tx)));
        NoticeClockJump(*next);
        const WallTime now = clock_.Wall();
        const std::set<RigId> own = own_rigs();
        if (recover) next->Recover(now, &own);
        NoticeRuns(*next, now);
        for (Request& request : requests) request.input(*next, now);
        next->Tick(now);
        const std::vector<LabEvent> events = ToEvents(next->TakeNotices(), now);
        const Changes changes = next->TakeChanges();
        if (changes.empty() && events.empty()) return core::Done{};
        lab_store::Save(tx, changes, ++version);
        lab_store::AddEvents(tx, events);
        return core::Done{};
      });
  if (!stored.ok()) {
    version_ = -1;  // whatever happened, the next turn starts from the disk
    return stored;
  }
  // Before anybody hears of it: a run or a command of an older epoch must not outlive the answer.
  FenceRigs(next->state());
  Publish(std::move(*next), version);
  return stored;
}

void LabService::FenceRigs(const LabState& state) {
  const std::set<RigId> own = own_rigs();
  for (const auto& [id, rig] : state.rigs) {
    if (!own.contains(id)) continue;
    std::uint64_t& fenced = fenced_epochs_[id];
    if (rig.epoch == fenced) continue;
    fenced = rig.epoch;
    duties_.Fence(id, rig.epoch);
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

/// Checks follow from the stored state, not from who changed it: so they survive a crash, and a
/// server checks its own rigs when another one ended the session.
void LabService::StartChecks() {
  const std::set<RigId> own = own_rigs();
  for (const auto& [id, rig] : scheduler_.state().rigs) {
    if (rig.status != RigStatus::kCleaning || !own.contains(id)) continue;
    std::uint64_t& checked = checked_epochs_[id];
    if (rig.epoch == checked) continue;
    checked = rig.epoch;
    duties_.StartCleaning({id, {}, rig.epoch, {}, rig.cleaning_due});
  }
}

}  // namespace faultlab::server::lab
