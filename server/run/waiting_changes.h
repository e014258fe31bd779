#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/types/component.h"

namespace faultlab::server {

/// What has become of a change, for the events of the run.
struct ChangeNote {
  std::string_view kind;  ///< "change_waits", "change_dropped" or "refused"
  core::Component component = core::Component::kR1;
  double value = 0.0;
  std::string text;
};

/// Live changes that came while the run learns its healthy rig. Such a change would spoil the
/// stretch by which the whole run is judged, so it waits for the end of the stretch; the newest for
/// a component wins.
///
///   Hold, Drop --> values --Next, after the stretch--> the rig
///                    +--> notes --> events of the run
///
/// Thread-safe. Who decides between Hold and the rig, and between Next and the rig, holds one lock
/// around both.
class WaitingChanges {
 public:
  using Values = std::map<core::Component, double>;
  using Change = Values::value_type;

  /// @param until_s  end of the stretch; nullopt: there is none, nothing waits
  explicit WaitingChanges(std::optional<double> until_s)
      : until_s_(until_s), open_(!until_s.has_value()) {}

  /// True: the change waits. False: it is for the rig, now.
  bool Hold(core::Component component, double value);
  /// The component shall be nominal: nothing waits for it any more.
  void Drop(core::Component component);
  void DropAll();

  /// The stretch is over: the next change for the rig. nullopt: none is left, and from now on
  /// nothing waits.
  std::optional<Change> Next();
  /// The rig did not take a change that Next gave.
  void Refuse(const Change& change, std::string reason);
  /// The run ends: nothing waits any more.
  void End();

  bool open() const;  ///< changes go to the rig
  Values values() const;
  /// What has happened since the last call, in order.
  std::vector<ChangeNote> TakeNotes();

 private:
  const std::optional<double> until_s_;
  mutable std::mutex mutex_;
  bool open_;
  Values values_;
  std::vector<ChangeNote> notes_;
};

}  // namespace faultlab::server
