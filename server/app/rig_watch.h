#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/clock.h"
#include "server/disk_reserve.h"
#include "server/lab/alarms.h"
#include "server/lab/lab_service.h"
#include "server/lab/relay_wear.h"
#include "server/repeated.h"
#include "server/run/rig_pool.h"
#include "server/run/rig_tally.h"

namespace faultlab::server {

/// Keeps what operators must know of the rigs: stores how often relays have closed, and raises and
/// ends alarms.
///
///   RigPool --TalliedRig--> RigTally --+
///   LabState, RigStatus, free disk ---+--> RigWatch, every 2 s --> Alarms, RelayWear
///
/// Simulators that anybody may use raise no alarms. Of servers that share a database, each looks
/// after its own rigs and disk; the one with the smallest id after what stands in the lab's state.
class RigWatch {
 public:
  struct Parts {
    lab::LabService& service;
    RigPool& rig_pool;
    lab::Alarms& alarms;
    lab::RelayWear& wear;
    DiskReserve disk;
    const Clock& clock;
    std::function<void(std::string_view)> log;
  };
  /// All parts must outlive it.
  explicit RigWatch(Parts parts);
  ~RigWatch();  ///< after a last look
  RigWatch(const RigWatch&) = delete;
  RigWatch& operator=(const RigWatch&) = delete;

 private:
  using Cause = std::pair<lab::AlarmKind, std::string>;
  using Causes = std::map<Cause, std::string>;  ///< with what is told of it

  void Look();
  void TellRestart();
  void Store(const RigTally::Taken& taken);
  Causes Find(const lab::LabState& state, const std::vector<RigStatus>& rigs);
  void AddStates(const lab::LabState& state, Causes& causes);
  void AddHours(const lab::LabState& state, Causes& causes) const;
  void AddRelays(const RigStatus& rig, Causes& causes);
  void AddDisk(Causes& causes) const;
  bool IsMine(const Cause& cause, const lab::LabState& state) const;
  bool Leads() const;

  const Parts parts_;
  const std::shared_ptr<RigTally> tally_ = std::make_shared<RigTally>();
  std::map<std::string, MonotonicTime> silent_since_;
  std::map<std::string, std::string> worn_;  ///< by rig: which relays; kept until one closes
  bool looked_ = false;
  std::optional<Repeated> looks_;
};

}  // namespace faultlab::server
