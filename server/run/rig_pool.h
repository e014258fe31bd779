#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "hardware/lcm/rig_finder.h"
#include "hardware/rig.h"
#include "server/lab/lease.h"
#include "server/run/rig_tally.h"

namespace faultlab::server {

/// A rig as shown in the list.
struct RigStatus {
  hardware::RigDescription description;
  std::string profile;  ///< "bench", "multisim"
  hardware::RigState state = hardware::RigState::kIdle;
  hardware::Epoch epoch{};
  bool leased = false;
  std::optional<hardware::Trip> trip{};             ///< blocks the rig until ClearTrip
  hardware::LoopQuality loop{};                     ///< over all leases, but for Pace::kFastest
  std::optional<hardware::RemoteRigInfo> remote{};  ///< of a remote rig: link, holder, calibration
};

/// The highest epoch that the rig's agent has seen: the laboratory goes on above it when it adopts
/// the rig. Refuses a rig without an agent of its own, one that nobody can use, one not heard.
core::Result<std::uint64_t> EpochSeenBy(const RigStatus& rig);

class RigPool;

/// How fast a run's time passes.
enum class Pace {
  kOfRig,   ///< as on a bench, or as the lab's simulators are set
  kFastest  ///< as fast as its reader reads, where the rig can: a simulator of this server
};

/// A rig held by a lease. The end of the hold is a safe stop and gives the rig back.
class RigHandle {
 public:
  RigHandle() = default;
  /// For a rig without a pool: a replay, which has one holder until its end.
  explicit RigHandle(std::shared_ptr<hardware::Rig> rig, Pace pace = Pace::kOfRig)
      : rig_(std::move(rig)), pace_(pace) {
    lease_.epoch = 1;
  }
  RigHandle(RigHandle&& other) noexcept { *this = std::move(other); }
  RigHandle& operator=(RigHandle&& other) noexcept;
  ~RigHandle() { Release(); }

  hardware::Rig& rig() const { return *rig_; }
  const std::shared_ptr<hardware::Rig>& shared_rig() const { return rig_; }
  const lab::Lease& lease() const { return lease_; }
  hardware::Epoch epoch() const { return hardware::Epoch{lease_.epoch}; }
  Pace pace() const { return pace_; }  ///< that it has
  /// True after the pool was fenced above this lease: the rig has been stopped.
  bool revoked() const { return revoked_ != nullptr && revoked_->load(); }
  void Release();

 private:
  friend class RigPool;
  RigPool* rig_pool_ = nullptr;  ///< null: a rig without a pool
  std::size_t slot_ = 0;
  lab::Lease lease_;
  std::shared_ptr<hardware::Rig> rig_;
  Pace pace_ = Pace::kOfRig;
  std::shared_ptr<std::atomic<bool>> revoked_;
};

/// All rigs of this server and the leases that hold them. The epochs come with the leases of the
/// lab; the pool makes none. Thread-safe.
class RigPool {
 public:
  using Factory = std::function<std::shared_ptr<hardware::Rig>()>;
  static constexpr std::chrono::seconds kPatience{5};

  /// A rig that `make` builds anew for each lease, so that a practice bench starts without trips.
  /// @param make_fastest  the same for Pace::kFastest; empty: there is none
  void Add(hardware::RigDescription description,
           std::string profile,
           Factory make,
           Factory make_fastest = {});

  /// A rig that exists between leases, too, and keeps its trip and its temperature.
  void AddResident(std::shared_ptr<hardware::Rig> rig, std::string profile);

  /// Adds a source of rigs that appear by themselves (agents on a bus). It is asked at each access
  /// to the pool. A name that this pool already has from elsewhere is not changed.
  struct Found {
    RigStatus status;
    Factory make;  ///< always the same rig
  };
  using Finder = std::function<std::vector<Found>()>;
  void SetFinder(Finder finder);

  /// Names on the bus that nothing proves (there is no key for them here), shown to operators. They
  /// are not rigs of this pool; a name that the pool has is left out.
  using UnprovenRigs = std::function<std::vector<RigStatus>()>;
  void SetUnprovenRigs(UnprovenRigs strangers);
  std::vector<RigStatus> ListUnprovenRigs() const;

  /// Asked before a lease acquires a far rig; waits up to the patience of Acquire, whose answer its
  /// error is. May be empty.
  using Gate = std::function<core::Status(const std::string& rig, std::chrono::milliseconds)>;
  void SetGate(Gate gate);

  /// Sets a function that is called when a hold has ended and its rig is free again. Any thread.
  /// May be empty.
  void OnRelease(std::function<void(const lab::Lease&)> told);

  /// Where all that is held from now on counts what it does; null: nowhere.
  void SetTally(std::shared_ptr<RigTally> tally);

  /// Acquires the rig of the lease. The holder of an older epoch is stopped and waited for, up to
  /// `patience`. kStale when the pool is fenced above the lease; kBusy when the lease has the
  /// rig already, or the older holder did not release it; kNotFound; kUnavailable when the rig does
  /// not answer.
  core::Result<RigHandle> Acquire(const lab::Lease& lease,
                                  std::chrono::milliseconds patience = kPatience,
                                  Pace pace = Pace::kOfRig);
  /// When this returns, no lease below `epoch` can acquire or command the rig, and a run with a
  /// lower epoch is stopping. An unknown rig is fenced when it appears.
  void Fence(const std::string& rig, std::uint64_t epoch);

  core::Result<RigStatus> Find(std::string_view id) const;
  enum class Like { kSimulator, kAnyRig };
  /// The first that is built like this, a simulator if there is one.
  core::Result<RigStatus> FindLike(const core::Bench& bench, Like which) const;
  std::vector<RigStatus> List() const;
  bool Holds(std::string_view id) const;  ///< true while a lease holds it

 private:
  friend class RigHandle;
  struct Slot {
    hardware::RigDescription description;
    std::string profile;
    Factory make, make_fastest;
    std::shared_ptr<hardware::Rig> rig;  ///< while held
    std::shared_ptr<hardware::Rig> resident;
    std::shared_ptr<std::atomic<bool>> revoked;  ///< of the hold; null: not held
    Pace pace = Pace::kOfRig;                    ///< of the hold
    std::uint64_t held_epoch = 0;
    hardware::RigState state = hardware::RigState::kIdle;  ///< last known, while not held
    std::optional<hardware::RemoteRigInfo> remote;         ///< last known
    hardware::LoopQuality loop;                            ///< of former rigs of this slot
  };
  RigStatus Describe(const Slot& slot) const;
  core::Result<std::size_t> Take(const lab::Lease& lease, std::chrono::milliseconds patience);
  void FenceFar(const std::string& rig, std::uint64_t epoch);
  std::shared_ptr<hardware::Rig> StopOlder(Slot& slot, std::uint64_t epoch);
  void Return(std::size_t slot);
  void LookAround() const;
  core::Status PassGate(const std::string& rig, std::chrono::milliseconds patience) const;

  Finder finder_;
  std::shared_ptr<RigTally> tally_;
  Gate gate_;
  UnprovenRigs unproven_rigs_;
  std::function<void(const lab::Lease&)> released_;
  mutable std::mutex mutex_;
  std::condition_variable returned_;
  mutable std::vector<Slot> slots_;
  std::map<std::string, lab::Fence, std::less<>> fences_;
};

}  // namespace faultlab::server
