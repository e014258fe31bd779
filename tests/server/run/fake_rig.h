#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "hardware/rig.h"
#include "tests/paper_bench.h"

namespace faultlab::tests {

/// A rig that returns the messages given by a test, and records the commands that it gets.
class FakeRig : public hardware::Rig {
 public:
  explicit FakeRig(std::string id = "fake-1") {
    description_.id = std::move(id);
    description_.bench = &paper::Bench();
  }

  void Say(hardware::RigMessage message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
    changed_.notify_all();
  }
  void End() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  /// The next Read throws.
  void BreakRead() {
    const std::lock_guard lock(mutex_);
    broken_ = true;
    changed_.notify_all();
  }
  std::vector<std::string> stops() const {
    const std::lock_guard lock(mutex_);
    return stops_;
  }
  /// Waits until the rig has received `count` commands.
  void AwaitCommands(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return commands_.size() >= count; });
  }
  /// Waits until the rig has been read so often without having said anything.
  void AwaitSilentReads(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return silent_reads_ >= count; });
  }
  hardware::Epoch fence() const {
    const std::lock_guard lock(mutex_);
    return epoch_;
  }
  std::vector<hardware::RigCommand> commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }

  const hardware::RigDescription& description() const override { return description_; }
  hardware::RigState state() const override { return hardware::RigState::kIdle; }
  core::Status Arm(hardware::RunPlan, hardware::Epoch epoch) override {
    const std::lock_guard lock(mutex_);
    epoch_ = epoch;
    return arm_answer_;
  }
  core::Status Start(hardware::Epoch) override { return core::Done{}; }
  core::Status Command(hardware::Epoch epoch, const hardware::RigCommand& command) override {
    const std::lock_guard lock(mutex_);
    if (epoch != epoch_) return core::Error{core::ErrorCode::kStale, "old epoch", "epoch"};
    commands_.push_back(command);
    changed_.notify_all();
    return core::Done{};
  }
  void KeepAlive(hardware::Epoch) override {}
  void Fence(hardware::Epoch epoch) override {
    const std::lock_guard lock(mutex_);
    epoch_ = epoch;
  }
  std::optional<hardware::Trip> trip() const override { return std::nullopt; }
  hardware::LoopQuality loop_quality() const override { return {}; }
  std::optional<std::chrono::nanoseconds> silence() const override {
    const std::lock_guard lock(mutex_);
    return silence_;
  }
  void FallSilentFor(std::optional<std::chrono::nanoseconds> silence) {
    const std::lock_guard lock(mutex_);
    silence_ = silence;
  }
  std::string kept_run() const override { return kept_run_; }
  core::Status Resume(const std::string& kept_run) override {
    if (kept_run == kept_run_) return core::Done{};
    return core::Error{core::ErrorCode::kNotFound, "another run", {}};
  }
  hardware::ReadStatus Read(std::vector<hardware::RigMessage>& out,
                            std::chrono::milliseconds patience) override {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [this] { return !messages_.empty() || ended_ || broken_; });
    if (std::exchange(broken_, false)) throw core::ContractError("the rig's code is broken");
    if (messages_.empty()) {
      ++silent_reads_;
      changed_.notify_all();
    }
    out.insert(out.end(), messages_.begin(), messages_.end());
    messages_.clear();
    return ended_ ? hardware::ReadStatus::kEnded : hardware::ReadStatus::kMore;
  }
  void SafeStop(std::string_view reason) override {
    const std::lock_guard lock(mutex_);
    stops_.emplace_back(reason);
    if (!ended_) {
      hardware::RigEvent stopped;
      stopped.kind = hardware::RigEventKind::kStopped;
      stopped.text = std::string(reason);
      messages_.push_back(stopped);
    }
    ended_ = true;
    changed_.notify_all();
  }
  core::Result<hardware::SelfTestReport> SelfTest(hardware::Epoch) override {
    return hardware::SelfTestReport{};
  }

  core::Status arm_answer_ = core::Done{};
  hardware::RigDescription description_;
  std::string kept_run_;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<hardware::RigMessage> messages_;
  std::vector<std::string> stops_;
  std::vector<hardware::RigCommand> commands_;
  hardware::Epoch epoch_{};
  std::optional<std::chrono::nanoseconds> silence_;
  int silent_reads_ = 0;
  bool ended_ = false;
  bool broken_ = false;
};

}  // namespace faultlab::tests
