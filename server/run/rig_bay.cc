#include "server/run/rig_bay.h"

#include <algorithm>
#include <utility>

namespace faultlab::server {

RigLease& RigLease::operator=(RigLease&& other) noexcept {
  if (this == &other) return *this;
  Release();
  bay_ = std::exchange(other.bay_, nullptr);
  slot_ = other.slot_;
  rig_ = std::move(other.rig_);
  epoch_ = other.epoch_;
  return *this;
}

void RigLease::Release() {
  if (rig_ == nullptr) return;
  rig_->SafeStop("the lease has ended");
  rig_.reset();
  if (RigBay* bay = std::exchange(bay_, nullptr)) bay->Return(slot_);
}

void RigBay::Add(hardware::RigDescription description,
                 std::string profile,
                 hardware::Epoch last_epoch,
                 Factory make) {
  const std::lock_guard lock(mutex_);
  Slot slot;
  slot.description = std::move(description);
  slot.profile = std::move(profile);
  slot.make = std::move(make);
  slot.epoch = last_epoch;
  slots_.push_back(std::move(slot));
}

void RigBay::AddResident(std::shared_ptr<hardware::Rig> rig, std::string profile) {
  const std::lock_guard lock(mutex_);
  Slot slot;
  slot.description = rig->description();
  slot.profile = std::move(profile);
  slot.make = [rig] { return rig; };
  slot.resident = std::move(rig);
  slots_.push_back(std::move(slot));
}

void RigBay::SetFinder(Finder finder) {
  const std::lock_guard lock(mutex_);
  finder_ = std::move(finder);
}

void RigBay::LookAround() const {
  if (!finder_) return;
  std::vector<Found> found = finder_();
  const std::lock_guard lock(mutex_);
  for (Found& rig : found) {
    const auto known = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& slot) {
      return slot.description.id == rig.status.description.id;
    });
    const bool is_new = known == slots_.end();
    Slot& slot = is_new ? slots_.emplace_back() : *known;
    if (is_new) {
      slot.epoch = rig.status.epoch;
      slot.profile = std::move(rig.status.profile);
      slot.make = std::move(rig.make);
    }
    slot.state = rig.status.state;
    slot.remote = std::move(rig.status.remote);
    if (!slot.leased) slot.description = std::move(rig.status.description);
  }
}

core::Result<RigLease> RigBay::Acquire(std::string_view id) {
  LookAround();
  std::size_t chosen = 0;
  Factory make;
  hardware::Epoch epoch{};
  {
    const std::lock_guard lock(mutex_);
    bool known = false;
    for (chosen = 0; chosen < slots_.size(); ++chosen) {
      const Slot& slot = slots_[chosen];
      const bool fits = id.empty() ? slot.description.kind == hardware::RigKind::kSimulated
                                   : slot.description.id == id;
      known = known || fits;
      if (fits && !slot.leased) break;
    }
    if (!known) {
      return core::Error{core::ErrorCode::kNotFound,
                         id.empty() ? std::string("This server has no simulated rig.")
                                    : "There is no rig '" + std::string(id) + "'.",
                         "/rig"};
    }
    if (chosen == slots_.size()) {
      return core::Error{core::ErrorCode::kBusy,
                         id.empty() ? std::string("Every simulated rig is in use; try again soon.")
                                    : "Rig '" + std::string(id) + "' is in use.",
                         "/rig"};
    }
    Slot& slot = slots_[chosen];
    slot.leased = true;
    slot.epoch = hardware::Epoch{static_cast<std::uint64_t>(slot.epoch) + 1};
    epoch = slot.epoch;
    make = slot.make;
  }
  // Building a rig may take a moment (a remote one answers over a network): not under the lock.
  std::shared_ptr<hardware::Rig> rig;
  try {
    rig = make();
  } catch (...) {
    Return(chosen);
    throw;
  }
  if (rig == nullptr) {
    Return(chosen);
    return core::Error{
        core::ErrorCode::kUnavailable, "Rig '" + std::string(id) + "' does not answer.", "/rig"};
  }
  const std::lock_guard lock(mutex_);
  slots_[chosen].rig = rig;
  return RigLease(this, chosen, std::move(rig), epoch);
}

void RigBay::Return(std::size_t slot) {
  std::shared_ptr<hardware::Rig> rig;  // outlives the lock: the end of a rig is a safe stop
  const std::lock_guard lock(mutex_);
  rig.swap(slots_[slot].rig);
  slots_[slot].leased = false;
  const bool lives_on = slots_[slot].resident != nullptr || slots_[slot].remote.has_value();
  if (rig != nullptr && !lives_on) slots_[slot].loop.Add(rig->loop_quality());
}

core::Status RigBay::ClearTrip(std::string_view id) {
  auto status = Find(id);
  if (!status) return status.error();
  if (!status.value().trip) {
    return core::Error{
        core::ErrorCode::kConflict, "No interlock holds rig '" + std::string(id) + "'.", ""};
  }
  auto lease = Acquire(id);
  if (!lease) return lease.error();
  hardware::RigCommand clear;
  clear.kind = hardware::RigCommand::Kind::kClearTrip;
  return lease.value().rig().Command(lease.value().epoch(), clear);
}

RigStatus RigBay::Describe(const Slot& slot) {
  RigStatus status;
  status.description = slot.description;
  status.profile = slot.profile;
  status.state = slot.state;
  status.epoch = slot.epoch;
  status.leased = slot.leased;
  status.loop = slot.loop;
  status.remote = slot.remote;
  const hardware::Rig* rig = slot.resident != nullptr ? slot.resident.get() : slot.rig.get();
  if (rig != nullptr) {
    status.state = rig->state();
    status.trip = rig->trip();
    status.loop.Add(rig->loop_quality());
  } else if (slot.remote) {
    status.trip = slot.remote->trip;
    status.loop = slot.remote->loop;
  }
  return status;
}

core::Result<RigStatus> RigBay::Find(std::string_view id) const {
  LookAround();
  const std::lock_guard lock(mutex_);
  for (const Slot& slot : slots_) {
    const bool fits = id.empty() ? slot.description.kind == hardware::RigKind::kSimulated
                                 : slot.description.id == id;
    if (fits) return Describe(slot);
  }
  return core::Error{
      core::ErrorCode::kNotFound, "There is no rig '" + std::string(id) + "'.", "/rig"};
}

std::vector<RigStatus> RigBay::List() const {
  LookAround();
  const std::lock_guard lock(mutex_);
  std::vector<RigStatus> out;
  for (const Slot& slot : slots_) out.push_back(Describe(slot));
  return out;
}

}  // namespace faultlab::server
