#include "server/app/recovery_service.h"

#include <algorithm>
#include <utility>

#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kTurn{20};
constexpr milliseconds kLook = seconds(2);
constexpr milliseconds kPatience = std::chrono::minutes(3);  ///< for a rig, and for the store

}  // namespace

RecoveryService::RecoveryService(RecordingStore& store,
                                 const Clock& clock,
                                 FindRig find_rig,
                                 std::function<void(std::string_view)> log)
    : store_(store), clock_(clock), find_rig_(std::move(find_rig)), log_(std::move(log)) {}

RecoveryService::~RecoveryService() {
  Stop();
}

void RecoveryService::Start(IsOurs is_ours, EndRun end_run) {
  is_ours_ = std::move(is_ours);
  end_run_ = std::move(end_run);
  thread_ = std::thread([this] { Loop(); });
}

void RecoveryService::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

core::Status RecoveryService::Await(const std::string& rig, milliseconds patience) {
  std::unique_lock lock(mutex_);
  const std::int64_t wanted = ++looks_wanted_;
  changed_.notify_all();
  const auto whole = [&] { return looks_done_ >= wanted && !rigs_.contains(rig); };
  changed_.wait_for(lock, patience, [&] { return stopping_ || whole(); });
  if (!stopping_ && whole()) return core::Done{};
  return core::Refuse("rest_awaited", "/rig", {{"rig", rig}});
}

void RecoveryService::Loop() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const std::int64_t wanted = looks_wanted_;
    const bool asked = wanted > looks_done_;
    lock.unlock();
    const MonotonicTime now = clock_.Monotonic();
    if (asked || now - looked_at_ >= kLook) {
      looked_at_ = now;
      Look();
    }
    Step();
    std::set<std::string> rigs = RigsWaiting();
    lock.lock();
    rigs_ = std::move(rigs);
    looks_done_ = wanted;
    changed_.notify_all();
    changed_.wait_for(lock, readings_.empty() ? kLook : kTurn, [&] {
      return stopping_ || looks_wanted_ > looks_done_;
    });
  }
}

void RecoveryService::Look() {
  auto missing = store_.AwaitingRecovery();
  if (!missing) return;  // asked again soon; what is known stays
  waiting_.clear();
  for (RunRecord& record : missing.value()) {
    if (readings_.contains(record.id) || !is_ours_(record)) continue;
    if (!Begin(record)) waiting_.push_back(std::move(record));
  }
}

/// @returns false when the rig must be waited for
bool RecoveryService::Begin(const RunRecord& record) {
  const MonotonicTime now = clock_.Monotonic();
  const MonotonicTime since = waiting_since_.try_emplace(record.id, now).first->second;
  auto rig = find_rig_(record.rig);
  core::Status begun = core::Refuse("no_rig", "/rig", {{"rig", record.rig}});
  if (rig != nullptr) {
    auto rest = std::make_unique<RunRecovery>(std::move(rig), store_, record);
    begun = rest->Begin();
    if (begun.ok()) {
      // Of a run that has ended too: its lease, which the agent keeps for a server that died, must
      // not stand in the way of the next one.
      end_run_(record.rig);
      readings_[record.id] = {std::move(rest), now};
      return true;
    }
    if (begun.error().code == core::ErrorCode::kNotFound) {
      GiveUp(record, begun.error().message);
      return true;
    }
  }
  if (now - since < kPatience) return false;
  GiveUp(record, begun.error().message);
  return true;
}

void RecoveryService::Step() {
  for (auto each = readings_.begin(); each != readings_.end();) {
    Reading& reading = each->second;
    const RunRecord record = reading.rest->record();
    const auto closed = reading.rest->Step();
    const MonotonicTime now = clock_.Monotonic();
    if (closed.ok()) reading.stored_at = now;
    const bool again = closed.ok() ? !closed.value()
                                   : MayPass(closed.error()) && now - reading.stored_at < kPatience;
    if (again) {
      ++each;
      continue;
    }
    if (!closed.ok()) GiveUp(record, closed.error().message);
    if (closed.ok()) log_("run " + record.id + ": its rest was read from rig " + record.rig);
    waiting_since_.erase(record.id);
    each = readings_.erase(each);
  }
}

void RecoveryService::GiveUp(const RunRecord& record, const std::string& why) {
  waiting_since_.erase(record.id);
  const core::Status ended = store_.EndRecovery(record.id, RunState::kInterrupted, {});
  log_("run " + record.id +
       " stays as its server left it: " + (ended.ok() ? why : ended.error().message));
}

std::set<std::string> RecoveryService::RigsWaiting() const {
  std::set<std::string> rigs;
  for (const auto& [id, reading] : readings_) rigs.insert(reading.rest->record().rig);
  for (const RunRecord& record : waiting_) rigs.insert(record.rig);
  return rigs;
}

}  // namespace faultlab::server
