#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "server/lab/lab_service.h"
#include "server/lab/rig_check.h"

namespace faultlab::server {

/// The checks between users that the lab has asked for, each once: after an outage of the database
/// it asks again, although the check may still go on. Not thread-safe.
class AskedChecks {
 public:
  /// False: this check waits already, or goes on.
  bool Add(const lab::Lease& lease);
  bool empty() const { return waiting_.empty(); }
  /// The one that was asked for first. Contract: there is one.
  lab::Lease Begin();
  /// Its verdict was told. The lab may ask for it anew.
  void End(const lab::Lease& lease) { known_.erase({lease.rig, lease.epoch}); }

 private:
  std::deque<lab::Lease> waiting_;
  std::set<std::pair<lab::RigId, std::uint64_t>> known_;  ///< waiting or in progress: epoch
};

/// The verdict of a check whose rig could not be acquired. If the rig does not answer yet, or the
/// database is away, the rig's health is unknown.
lab::RigVerdict NotBegun(const core::Error& error);

/// Tells the lab the result of a check. If a newer check of the rig has begun, this one is stale
/// and refused, as it should be.
/// @returns whether it must be told again: the database takes nothing now, and what an operator has
///   asked for beside the check would not be done twice
bool TellVerdict(lab::LabService& lab,
                 const lab::Lease& lease,
                 const lab::RigVerdict& verdict,
                 const std::function<void(std::string_view)>& log);

}  // namespace faultlab::server
