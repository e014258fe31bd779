#include "server/run/rig_pool.h"

#include <algorithm>
#include <utility>

#include "server/run/refusals.h"
#include "server/run/tallied_rig.h"

namespace faultlab::server {

RigHandle& RigHandle::operator=(RigHandle&& other) noexcept {
  if (this == &other) return *this;
  Release();
  rig_pool_ = std::exchange(other.rig_pool_, nullptr);
  slot_ = other.slot_;
  lease_ = std::move(other.lease_);
  rig_ = std::move(other.rig_);
  pace_ = other.pace_;
  revoked_ = std::move(other.revoked_);
  return *this;
}

void RigHandle::Release() {
  if (rig_ == nullptr) return;
  rig_->SafeStop("the run has ended");
  rig_.reset();
  RigPool* rig_pool = std::exchange(rig_pool_, nullptr);
  if (rig_pool == nullptr) return;
  rig_pool->Return(slot_);
  if (rig_pool->released_) rig_pool->released_(lease_);
}

void RigPool::Add(hardware::RigDescription description,
                  std::string profile,
                  Factory make,
                  Factory make_fastest) {
  const std::lock_guard lock(mutex_);
  Slot slot;
  slot.description = std::move(description);
  slot.profile = std::move(profile);
  slot.make = std::move(make);
  slot.make_fastest = std::move(make_fastest);
  slots_.push_back(std::move(slot));
}

void RigPool::AddResident(std::shared_ptr<hardware::Rig> rig, std::string profile) {
  const std::lock_guard lock(mutex_);
  Slot slot;
  slot.description = rig->description();
  slot.profile = std::move(profile);
  slot.make = [rig] { return rig; };
  slot.resident = std::move(rig);
  slots_.push_back(std::move(slot));
}

void RigPool::SetFinder(Finder finder) {
  const std::lock_guard lock(mutex_);
  finder_ = std::move(finder);
}

void RigPool::SetUnprovenRigs(UnprovenRigs strangers) {
  const std::lock_guard lock(mutex_);
  unproven_rigs_ = std::move(strangers);
}

std::vector<RigStatus> RigPool::ListUnprovenRigs() const {
  if (!unproven_rigs_) return {};
  std::vector<RigStatus> strangers = unproven_rigs_();
  const std::lock_guard lock(mutex_);
  std::erase_if(strangers, [this](const RigStatus& stranger) {
    return std::ranges::any_of(
        slots_, [&](const Slot& slot) { return slot.description.id == stranger.description.id; });
  });
  return strangers;
}

void RigPool::SetGate(Gate gate) {
  const std::lock_guard lock(mutex_);
  gate_ = std::move(gate);
}

core::Status RigPool::PassGate(const std::string& rig, std::chrono::milliseconds patience) const {
  Gate gate;
  {
    const std::lock_guard lock(mutex_);
    const bool far = std::ranges::any_of(slots_, [&](const Slot& slot) {
      return slot.description.id == rig && slot.remote.has_value();
    });
    if (far) gate = gate_;
  }
  return gate ? gate(rig, patience) : core::Done{};
}

void RigPool::SetTally(std::shared_ptr<RigTally> tally) {
  const std::lock_guard lock(mutex_);
  tally_ = std::move(tally);
}

void RigPool::OnRelease(std::function<void(const lab::Lease&)> told) {
  released_ = std::move(told);
}

void RigPool::LookAround() const {
  Finder finder;
  {
    const std::lock_guard lock(mutex_);
    finder = finder_;
  }
  if (!finder) return;
  std::vector<Found> found = finder();
  const std::lock_guard lock(mutex_);
  for (Found& rig : found) {
    const auto known = std::ranges::find_if(
        slots_, [&](const Slot& slot) { return slot.description.id == rig.status.description.id; });
    const bool is_new = known == slots_.end();
    if (!is_new && !known->remote) continue;  // a local rig stays local
    Slot& slot = is_new ? slots_.emplace_back() : *known;
    if (is_new) {
      slot.profile = std::move(rig.status.profile);
      slot.make = std::move(rig.make);
    }
    slot.state = rig.status.state;
    slot.remote = std::move(rig.status.remote);
    if (slot.revoked == nullptr) slot.description = std::move(rig.status.description);
  }
}

/// Called with the mutex held. Returns the rig that must be fenced after unlocking; null when
/// nothing older runs.
std::shared_ptr<hardware::Rig> RigPool::StopOlder(Slot& slot, std::uint64_t epoch) {
  if (slot.revoked == nullptr || slot.held_epoch >= epoch) return nullptr;
  *slot.revoked = true;
  return slot.rig;
}

void RigPool::Fence(const std::string& rig, std::uint64_t epoch) {
  std::shared_ptr<hardware::Rig> running;
  {
    const std::lock_guard lock(mutex_);
    fences_[rig].Raise(epoch);
    for (Slot& slot : slots_) {
      if (slot.description.id == rig) running = StopOlder(slot, epoch);
    }
  }
  returned_.notify_all();
  if (running != nullptr) {
    running->Fence(hardware::Epoch{epoch});
  } else {
    FenceFar(rig, epoch);
  }
}

/// A far rig may play on after its server has died: nobody here holds it, but from this epoch on
/// somebody else answers for the motor.
void RigPool::FenceFar(const std::string& rig, std::uint64_t epoch) {
  Factory make;
  {
    const std::lock_guard lock(mutex_);
    for (const Slot& slot : slots_) {
      const bool plays =
          slot.remote && slot.revoked == nullptr && slot.remote->state != hardware::RigState::kIdle;
      if (slot.description.id == rig && plays) make = slot.make;
    }
  }
  const std::shared_ptr<hardware::Rig> far = make ? make() : nullptr;
  if (far != nullptr) far->Fence(hardware::Epoch{epoch});
}

/// Reserves the slot of the lease; its rig is not made yet.
core::Result<std::size_t> RigPool::Take(const lab::Lease& lease,
                                        std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  const auto found = std::ranges::find_if(
      slots_, [&](const Slot& slot) { return slot.description.id == lease.rig; });
  if (found == slots_.end()) return core::Refuse("no_rig", "/rig", {{"rig", lease.rig}});
  const auto index = static_cast<std::size_t>(found - slots_.begin());
  lab::Fence& fence = fences_[lease.rig];
  if (!fence.Admits(lease.epoch)) return core::Refuse("turn_is_over", "/rig", {{"rig", lease.rig}});
  fence.Raise(lease.epoch);
  if (const std::shared_ptr<hardware::Rig> older = StopOlder(slots_[index], lease.epoch)) {
    lock.unlock();
    older->Fence(hardware::Epoch{lease.epoch});
    lock.lock();
  }
  const auto free = [&] {
    const Slot& slot = slots_[index];
    return slot.revoked == nullptr || slot.held_epoch >= lease.epoch || !fence.Admits(lease.epoch);
  };
  const bool in_time = returned_.wait_for(lock, patience, free);
  if (!fence.Admits(lease.epoch)) return core::Refuse("turn_is_over", "/rig", {{"rig", lease.rig}});
  Slot& slot = slots_[index];
  if (!in_time || slot.revoked != nullptr) {
    return core::Refuse("rig_in_use", "/rig", {{"rig", lease.rig}});
  }
  slot.revoked = std::make_shared<std::atomic<bool>>(false);
  slot.held_epoch = lease.epoch;
  return index;
}

core::Result<RigHandle> RigPool::Acquire(const lab::Lease& lease,
                                         std::chrono::milliseconds patience,
                                         Pace pace) {
  LookAround();
  FenceFar(lease.rig,
           lease.epoch);  // first: the gate waits for what a run that goes on still gives
  TRY_DONE(PassGate(lease.rig, patience));
  TRY(const auto index, Take(lease, patience));
  // Building a rig may take a moment (a remote rig answers over a network), so it is done without
  // the lock.
  Factory make;
  {
    const std::lock_guard lock(mutex_);
    const Slot& slot = slots_[index];
    if (!slot.make_fastest) pace = Pace::kOfRig;
    make = pace == Pace::kFastest ? slot.make_fastest : slot.make;
  }
  std::shared_ptr<hardware::Rig> rig;
  try {
    rig = make();
  } catch (...) {
    Return(index);
    throw;
  }
  if (rig == nullptr) {
    Return(index);
    return core::Refuse("rig_silent", "/rig", {{"rig", lease.rig}});
  }
  RigHandle hold;
  {
    const std::lock_guard lock(mutex_);
    Slot& slot = slots_[index];
    slot.rig = rig;
    slot.pace = pace;
    hold.rig_pool_ = this;
    hold.slot_ = index;
    hold.lease_ = lease;
    hold.pace_ = pace;
    hold.rig_ = tally_ ? std::make_shared<TalliedRig>(std::move(rig), tally_) : std::move(rig);
    hold.revoked_ = slot.revoked;
  }
  // A fence that came while the rig was being made had no rig to stop.
  if (hold.revoked()) return core::Refuse("turn_is_over", "/rig", {{"rig", lease.rig}});
  return hold;
}

void RigPool::Return(std::size_t index) {
  std::shared_ptr<hardware::Rig> rig;  // destroyed after unlocking: its end is a safe stop
  {
    const std::lock_guard lock(mutex_);
    Slot& slot = slots_[index];
    rig.swap(slot.rig);
    slot.revoked.reset();
    const bool lives_on = slot.resident != nullptr || slot.remote.has_value();
    // Whose clock never sleeps is never late.
    const bool keeps_time = slot.pace == Pace::kOfRig;
    if (rig != nullptr && !lives_on && keeps_time) slot.loop.Add(rig->loop_quality());
  }
  returned_.notify_all();
}

RigStatus RigPool::Describe(const Slot& slot) const {
  RigStatus status;
  status.description = slot.description;
  status.profile = slot.profile;
  status.state = slot.state;
  const auto fence = fences_.find(slot.description.id);
  if (fence != fences_.end()) status.epoch = hardware::Epoch{fence->second.epoch()};
  status.leased = slot.revoked != nullptr;
  status.loop = slot.loop;
  status.remote = slot.remote;
  const hardware::Rig* rig = slot.resident != nullptr ? slot.resident.get() : slot.rig.get();
  if (rig != nullptr) {
    status.state = rig->state();
    status.trip = rig->trip();
    if (slot.pace == Pace::kOfRig) status.loop.Add(rig->loop_quality());
  } else if (slot.remote) {
    status.trip = slot.remote->trip;
    status.loop = slot.remote->loop;
  }
  return status;
}

core::Result<RigStatus> RigPool::Find(std::string_view id) const {
  LookAround();
  const std::lock_guard lock(mutex_);
  for (const Slot& slot : slots_) {
    if (slot.description.id == id) return Describe(slot);
  }
  return core::Refuse("no_rig", "/rig", {{"rig", std::string(id)}});
}

core::Result<RigStatus> RigPool::FindLike(const core::Bench& bench, Like which) const {
  LookAround();
  const std::lock_guard lock(mutex_);
  const Slot* like = nullptr;
  for (const Slot& slot : slots_) {
    const hardware::RigDescription& about = slot.description;
    if (about.bench->id != bench.id) continue;
    if (about.kind == hardware::RigKind::kSimulated) return Describe(slot);
    if (like == nullptr && which == Like::kAnyRig) like = &slot;
  }
  if (like != nullptr) return Describe(*like);
  return core::Refuse("no_simulator", "/bench", {{"bench", bench.name}});
}

std::vector<RigStatus> RigPool::List() const {
  LookAround();
  const std::lock_guard lock(mutex_);
  std::vector<RigStatus> out;
  for (const Slot& slot : slots_) out.push_back(Describe(slot));
  return out;
}

bool RigPool::Holds(std::string_view id) const {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(slots_, [&](const Slot& slot) {
    return slot.description.id == id && slot.revoked != nullptr;
  });
}

core::Result<std::uint64_t> EpochSeenBy(const RigStatus& rig) {
  const auto& remote = rig.remote;
  if (!remote) return core::Refuse("not_adoptable");
  if (remote->refusal) {
    return refusal::RigRefused(rig.description.id, *remote).As(core::ErrorCode::kConflict);
  }
  if (!remote->epoch || remote->link == hardware::LinkState::kLost) {
    return core::Refuse("agent_silent");
  }
  return static_cast<std::uint64_t>(*remote->epoch);
}

}  // namespace faultlab::server
