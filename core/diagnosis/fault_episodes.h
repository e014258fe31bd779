#pragma once

#include <optional>
#include <vector>

#include "core/diagnosis/diagnosis.h"

namespace faultlab::core {

/// The stretches of a record in which the rig was not nominal, in time order; the newest one may be
/// open.
class FaultEpisodes {
 public:
  /// A new alarm: ends the open episode, if there is one, at `verdict.detected_at_s`.
  void Open(const Verdict& verdict);
  /// Removes what the newest alarm has begun, because it was withdrawn: an episode, or a further
  /// change of the episode before it, which then ends at that alarm.
  void Withdraw();
  /// The same, but nothing is known of that alarm: the episode before it goes on.
  /// @returns its verdict
  const Verdict& Resume();

  /// `next` is the verdict about the newest episode. If it names a component of the episode that
  /// this alarm has ended, both are one episode: the value has changed further, or the first fit
  /// was too early. Then `next` takes the detection and the onset of the first episode, and
  /// its own become the newest of `further`.
  void Update(Verdict& next, FaultShape shape, double alarm_t_s);
  /// The fault of the open episode moves, and `next` says where it is: the detection and the onset
  /// stay.
  void GoOn(Verdict& next);

  const std::vector<FaultEpisode>& list() const { return list_; }

 private:
  bool ContinuesTheOneBefore(const Verdict& next, double alarm_t_s) const;

  std::vector<FaultEpisode> list_;
  bool open_ = false;
  /// The episode before the newest alarm, when that alarm belongs to it.
  std::optional<FaultEpisode> continued_;
};

}  // namespace faultlab::core
