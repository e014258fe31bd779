#pragma once

#include <vector>

#include "core/diagnosis/diagnosis.h"

namespace faultlab::core {

/// The stretches of a record in which the rig was not nominal, in time order; the newest one may be
/// open.
class FaultEpisodes {
 public:
  /// A new alarm: ends the open episode, if there is one, at `verdict.detected_at_s`.
  void Open(const Verdict& verdict);
  /// Removes the newest episode, because its alarm was withdrawn.
  void Withdraw();

  /// `next` is the verdict about the newest episode. If it names a component of the episode that
  /// this alarm has ended, both are one episode: the value has changed further, or the first fit
  /// was too early. Then `next` takes the detection and the onset of the first episode.
  void Update(Verdict& next, FaultShape shape, double alarm_t_s);

  const std::vector<FaultEpisode>& list() const { return list_; }

 private:
  bool ContinuesTheOneBefore(const Verdict& next, double alarm_t_s) const;

  std::vector<FaultEpisode> list_;
  bool open_ = false;
  bool merged_ = false;  ///< the newest alarm belongs to the episode before it
};

}  // namespace faultlab::core
