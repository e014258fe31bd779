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

namespace faultlab::server {

/// A rig as the list shows it.
struct RigStatus {
  hardware::RigDescription description;
  std::string profile;  ///< "bench", "multisim"
  hardware::RigState state = hardware::RigState::kIdle;
  hardware::Epoch epoch{};
  bool leased = false;
  std::optional<hardware::Trip> trip{};             ///< holds the rig until ClearTrip
  hardware::LoopQuality loop{};                     ///< over all leases
  std::optional<hardware::RemoteRigInfo> remote{};  ///< of a far rig: link, holder, calibration
};

class RigBay;

/// A rig in the hands of a lease. Its end is a safe stop and gives the rig back.
class RigHold {
 public:
  RigHold() = default;
  /// Of a rig that belongs to no bay: a replay, whose one holder keeps it to its end.
  explicit RigHold(std::shared_ptr<hardware::Rig> rig) : rig_(std::move(rig)) { lease_.epoch = 1; }
  RigHold(RigHold&& other) noexcept { *this = std::move(other); }
  RigHold& operator=(RigHold&& other) noexcept;
  ~RigHold() { Release(); }

  hardware::Rig& rig() const { return *rig_; }
  const std::shared_ptr<hardware::Rig>& shared_rig() const { return rig_; }
  const lab::Lease& lease() const { return lease_; }
  hardware::Epoch epoch() const { return hardware::Epoch{lease_.epoch}; }
  /// True once the bay was fenced above this lease: the rig has been stopped for it.
  bool revoked() const { return revoked_ != nullptr && revoked_->load(); }
  void Release();

 private:
  friend class RigBay;
  RigBay* bay_ = nullptr;  ///< null: a rig that belongs to no bay
  std::size_t slot_ = 0;
  lab::Lease lease_;
  std::shared_ptr<hardware::Rig> rig_;
  std::shared_ptr<std::atomic<bool>> revoked_;
};

/// All rigs of this server and whose hands they are in. It makes no epochs: those come with the
/// leases of the lab. Thread-safe.
class RigBay {
 public:
  using Factory = std::function<std::shared_ptr<hardware::Rig>()>;

  /// A rig that `make` builds anew for each lease: a practice bench forgets its trips.
  void Add(hardware::RigDescription description, std::string profile, Factory make);

  /// A rig that is there between leases, too, and keeps its trip and its heat.
  void AddResident(std::shared_ptr<hardware::Rig> rig, std::string profile);

  /// Where rigs turn up by themselves (agents on a bus). Asked at each look at the bay. A name that
  /// this bay has by other means stays what it is.
  struct Found {
    RigStatus status;
    Factory make;  ///< always the same rig
  };
  using Finder = std::function<std::vector<Found>()>;
  void SetFinder(Finder finder);

  /// Names on the bus that nothing proves (no key here), for operators to see. They are no rigs of
  /// this bay; a name that the bay has is left out.
  using Strangers = std::function<std::vector<RigStatus>()>;
  void SetStrangers(Strangers strangers);
  std::vector<RigStatus> ListStrangers() const;

  /// Told when a hold has ended and its rig is free again. Any thread. Empty: nobody.
  void OnRelease(std::function<void(const lab::Lease&)> told);

  /// The rig of the lease. A holder of an older epoch is stopped and waited for up to `patience`.
  /// kStale when the bay is fenced above the lease; kBusy when the lease has the rig already, or
  /// the older holder did not let go; kNotFound; kUnavailable when the rig does not answer.
  core::Result<RigHold> Acquire(const lab::Lease& lease,
                                std::chrono::milliseconds patience = std::chrono::seconds(5));
  /// When this returns, nothing below `epoch` can acquire the rig or command it, and what runs
  /// under a lower one is stopping. An unknown rig is fenced when it turns up.
  void Fence(const std::string& rig, std::uint64_t epoch);

  /// The description of that rig, or of the first simulated one when `id` is empty.
  core::Result<RigStatus> Find(std::string_view id) const;
  std::vector<RigStatus> List() const;
  bool Holds(std::string_view id) const;  ///< somebody's hands are on it

 private:
  friend class RigHold;
  struct Slot {
    hardware::RigDescription description;
    std::string profile;
    Factory make;
    std::shared_ptr<hardware::Rig> rig;  ///< while held
    std::shared_ptr<hardware::Rig> resident;
    std::shared_ptr<std::atomic<bool>> revoked;  ///< of the hold; null = nobody holds it
    std::uint64_t held_epoch = 0;
    hardware::RigState state = hardware::RigState::kIdle;  ///< as found, while not held
    std::optional<hardware::RemoteRigInfo> remote;         ///< as found
    hardware::LoopQuality loop;                            ///< of the rigs that are no more
  };
  RigStatus Describe(const Slot& slot) const;
  core::Result<std::size_t> Take(const lab::Lease& lease, std::chrono::milliseconds patience);
  std::shared_ptr<hardware::Rig> StopOlder(Slot& slot, std::uint64_t epoch);
  void Return(std::size_t slot);
  void LookAround() const;

  Finder finder_;
  Strangers strangers_;
  std::function<void(const lab::Lease&)> released_;
  mutable std::mutex mutex_;
  std::condition_variable returned_;
  mutable std::vector<Slot> slots_;
  std::map<std::string, lab::Fence, std::less<>> fences_;
};

}  // namespace faultlab::server
