#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/component.h"
#include "core/types/result.h"

namespace faultlab::server {

/// The outcome of a change, for the events of the run.
struct ChangeNote {
  std::string_view kind;  ///< "change_waits", "change_dropped" or "refused"
  core::Component component{};
  double value = 0.0;
  std::string text;
  std::string reason{};  ///< of a refusal, as in core::Error
  std::vector<core::ErrorParameter> parameters{};
};

/// Live changes that come while the run calibrates its model of the healthy rig. Such a change
/// would disturb the stretch on which the diagnosis of the whole run depends, so it waits for the
/// end of the stretch; the newest change of a component replaces earlier ones.
///
///   Defer, Drop --> values --Next, after the stretch--> the rig
///                    +--> notes --> events of the run
///
/// Thread-safe. The caller must hold one lock around the choice between Defer and the rig, and
/// around Next and the rig.
class WaitingChanges {
 public:
  using Values = std::map<core::Component, double, core::ByIndex>;
  using Change = Values::value_type;

  /// @param until_s  end of the stretch; nullopt: there is none, nothing waits
  explicit WaitingChanges(std::optional<double> until_s)
      : until_s_(until_s), open_(!until_s.has_value()) {}

  /// True: the change waits. False: send it to the rig now.
  bool Defer(core::Component component, double value);
  /// The component is set to nominal: its waiting change is dropped.
  void Drop(core::Component component);
  void DropAll();

  /// After the stretch: the next change for the rig. nullopt: none is left, and later changes do
  /// not wait.
  std::optional<Change> Next();
  /// The rig refused a change that Next returned.
  void Refuse(const Change& change, const core::Error& error);
  /// Another stretch has begun, which ends at `until_s`: changes wait again, also those that still
  /// did.
  void Restart(double until_s);
  /// The run ends: waiting changes are dropped.
  void End();

  bool open() const;  ///< true: changes go to the rig at once
  Values values() const;
  /// The notes since the last call, in order.
  std::vector<ChangeNote> TakeNotes();

 private:
  mutable std::mutex mutex_;
  std::optional<double> until_s_;
  bool open_;
  Values values_;
  std::vector<ChangeNote> notes_;
};

}  // namespace faultlab::server
