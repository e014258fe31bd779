#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>

#include "server/lab/lab_service.h"

namespace faultlab::server::lab {

/// A bench whose checks wait until the test lets them pass.
class WaitingBench : public RigDuties {
 public:
  void Fence(const RigId& rig, std::uint64_t epoch) override {
    const std::lock_guard lock(mutex_);
    fences_[rig] = epoch;
  }
  void StartCleaning(const Lease& lease) override {
    {
      const std::lock_guard lock(mutex_);
      checks_[lease.rig] = lease.epoch;
    }
    asked_.notify_all();
  }
  bool RunInProgress(const RigId& rig) override {
    const std::lock_guard lock(mutex_);
    return rig == running_;
  }
  void SetRunning(const RigId& rig) {
    const std::lock_guard lock(mutex_);
    running_ = rig;
  }
  /// The service requests a check after it has answered the request that caused it; this waits for
  /// it.
  void AwaitChecks(std::size_t count) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(
        asked_.wait_for(lock, std::chrono::minutes(2), [&] { return checks_.size() >= count; }));
  }
  void PassChecks(LabService& service) {
    std::map<RigId, std::uint64_t> checks;
    {
      const std::lock_guard lock(mutex_);
      checks.swap(checks_);
    }
    for (const auto& [rig, epoch] : checks) {
      EXPECT_TRUE(service.CleaningDone(rig, epoch, true, "").ok());
    }
  }
  /// The checks have passed, but the result does not reach the database.
  void FailToPassChecks(LabService& service) {
    std::map<RigId, std::uint64_t> checks;
    {
      const std::lock_guard lock(mutex_);
      checks.swap(checks_);
    }
    for (const auto& [rig, epoch] : checks) {
      EXPECT_FALSE(service.CleaningDone(rig, epoch, true, "").ok());
    }
  }
  std::uint64_t fence(const RigId& rig) {
    const std::lock_guard lock(mutex_);
    return fences_[rig];
  }

 private:
  std::mutex mutex_;
  std::condition_variable asked_;
  std::map<RigId, std::uint64_t> fences_;
  std::map<RigId, std::uint64_t> checks_;
  RigId running_;
};

}  // namespace faultlab::server::lab
