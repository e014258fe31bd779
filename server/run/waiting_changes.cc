#include "server/run/waiting_changes.h"
#include "core/types/number_text.h"

namespace faultlab::server {

bool WaitingChanges::Defer(core::Component component, double value) {
  const std::lock_guard lock(mutex_);
  if (open_) return false;
  values_[component] = value;
  const std::string text = core::Format("until the healthy rig is learnt, at %g s", *until_s_);
  notes_.push_back({"change_waits", component, value, text});
  return true;
}

void WaitingChanges::Drop(core::Component component) {
  const std::lock_guard lock(mutex_);
  const auto found = values_.find(component);
  if (found == values_.end()) return;
  notes_.push_back({"change_dropped", component, found->second, {}});
  values_.erase(found);
}

void WaitingChanges::DropAll() {
  for (const auto& [component, value] : values()) Drop(component);
}

std::optional<WaitingChanges::Change> WaitingChanges::Next() {
  const std::lock_guard lock(mutex_);
  if (values_.empty()) {
    open_ = true;
    return std::nullopt;
  }
  const Change change = *values_.begin();
  values_.erase(values_.begin());
  return change;
}

void WaitingChanges::Refuse(const Change& change, const core::Error& error) {
  const std::lock_guard lock(mutex_);
  notes_.push_back(
      {"refused", change.first, change.second, error.message, error.reason, error.parameters});
}

void WaitingChanges::Restart(double until_s) {
  const std::lock_guard lock(mutex_);
  until_s_ = until_s;
  open_ = false;
}

void WaitingChanges::End() {
  const std::lock_guard lock(mutex_);
  values_.clear();
  open_ = true;
}

bool WaitingChanges::open() const {
  const std::lock_guard lock(mutex_);
  return open_;
}

WaitingChanges::Values WaitingChanges::values() const {
  const std::lock_guard lock(mutex_);
  return values_;
}

std::vector<ChangeNote> WaitingChanges::TakeNotes() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notes_, {});
}

}  // namespace faultlab::server
