#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "hardware/lcm/rig_finder.h"
#include "hardware/rig.h"

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

/// One holder's right to one rig. Its end is a safe stop and gives the rig back.
class RigLease {
 public:
  RigLease() = default;
  RigLease(RigBay* bay, std::size_t slot, std::shared_ptr<hardware::Rig> rig, hardware::Epoch epoch)
      : bay_(bay), slot_(slot), rig_(std::move(rig)), epoch_(epoch) {}
  RigLease(RigLease&& other) noexcept { *this = std::move(other); }
  RigLease& operator=(RigLease&& other) noexcept;
  ~RigLease() { Release(); }

  hardware::Rig& rig() const { return *rig_; }
  const std::shared_ptr<hardware::Rig>& shared_rig() const { return rig_; }
  hardware::Epoch epoch() const { return epoch_; }
  void Release();

 private:
  RigBay* bay_ = nullptr;  ///< null: a rig that belongs to no bay (a replay)
  std::size_t slot_ = 0;
  std::shared_ptr<hardware::Rig> rig_;
  hardware::Epoch epoch_{};
};

/// All rigs of this server and who holds them. Each lease has a higher epoch than the one before.
/// Thread-safe.
class RigBay {
 public:
  using Factory = std::function<std::shared_ptr<hardware::Rig>()>;

  /// A rig that `make` builds anew for each lease: a practice bench forgets its trips.
  void Add(hardware::RigDescription description,
           std::string profile,
           hardware::Epoch last_epoch,
           Factory make);

  /// A rig that is there between leases, too, and keeps its trip and its heat.
  void AddResident(std::shared_ptr<hardware::Rig> rig, std::string profile);

  /// Where rigs turn up by themselves (agents on a bus). Asked at each look at the bay.
  struct Found {
    RigStatus status;  ///< epoch: the last one that may have been given out
    Factory make;      ///< always the same rig
  };
  using Finder = std::function<std::vector<Found>()>;
  void SetFinder(Finder finder);

  /// `id` empty: any free simulated rig. kNotFound, or kBusy when it is held.
  core::Result<RigLease> Acquire(std::string_view id);
  /// The description of that rig, or of the first simulated one when `id` is empty.
  core::Result<RigStatus> Find(std::string_view id) const;
  std::vector<RigStatus> List() const;
  /// Makes the rig safe and opens its latch. kConflict when no interlock holds it, kBusy while it
  /// is leased, the rig's own refusal when it does not get safe.
  core::Status ClearTrip(std::string_view id);

 private:
  friend class RigLease;
  struct Slot {
    hardware::RigDescription description;
    std::string profile;
    Factory make;
    std::shared_ptr<hardware::Rig> rig;  ///< while leased
    std::shared_ptr<hardware::Rig> resident;
    hardware::Epoch epoch{};
    bool leased = false;
    hardware::RigState state = hardware::RigState::kIdle;  ///< as found, while not leased
    std::optional<hardware::RemoteRigInfo> remote;         ///< as found
    hardware::LoopQuality loop;                            ///< of the rigs that are no more
  };
  static RigStatus Describe(const Slot& slot);
  void Return(std::size_t slot);
  void LookAround() const;

  Finder finder_;
  mutable std::mutex mutex_;
  mutable std::vector<Slot> slots_;
};

}  // namespace faultlab::server
