#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/clock.h"
#include "server/lab/lab_service.h"
#include "server/run/rig_pool.h"
#include "server/upkeep/rig_classes.h"

namespace faultlab::server {

/// Tells the lab which rigs this server has and whether they answer. It decides by the clock alone
/// and has no thread: its owner calls Take again and again, always from the same one.
class RollCall {
 public:
  /// Both must outlive it. Far rigs are heard within the next seconds.
  RollCall(lab::LabService& lab, const Clock& clock, std::function<void(std::string_view)> log);

  /// Far rigs that are there have been heard since the start. Any thread.
  bool AllHeard() const { return clock_.Monotonic() >= heard_from_; }
  /// @param rigs  those of this server now
  void Take(std::vector<RigStatus> rigs);

 private:
  struct Change {
    RigStatus rig;
    std::string why;        ///< it is offline; empty: it can be used
    bool describe = false;  ///< the lab does not know the rig, or has another description of it
  };
  std::vector<Change> FindChanges(const lab::LabState& state, std::vector<RigStatus> rigs);
  std::vector<lab::RigId> FindGone(const lab::LabState& state, const std::vector<RigStatus>& rigs);
  bool IsAwaited(const lab::LabState& state, const lab::RigId& silent);

  lab::LabService& lab_;
  const Clock& clock_;
  const std::function<void(std::string_view)> log_;
  const MonotonicTime heard_from_;
  std::map<lab::RigId, MonotonicTime> silent_since_;
};

}  // namespace faultlab::server
