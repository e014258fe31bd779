#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/detection/detector.h"
#include "core/isolation/isolation.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The samples that a fit needs: the newest ones while nothing has happened, and after an alarm the
/// history before it with everything since. Bounded: at most some 2600 samples.
class AlarmRecord {
 public:
  AlarmRecord();

  /// A sample without an alarm.
  void Remember(const Sample& sample);
  /// A sample after the alarm.
  void Append(const Sample& sample);

  /// The newest sample has raised `alarm`; `alarmed`: an earlier alarm was still open.
  void Open(const Alarm& alarm, bool alarmed);
  /// Nothing came of the alarm: its newest samples are history again.
  void Close();

  /// True at the samples after the alarm at which the hypotheses are to be fitted.
  bool FitIsDue() const { return since_alarm_ >= next_fit_; }
  void ScheduleNextFit();

  /// Drops what is too old, and fills samples, alarm_at, fit_from, settled and, once the onset has
  /// left the samples, onset.
  void Fill(IsolationTask& task);

  /// What a fit has found; the detector's own estimate holds until then.
  void SetOnset(const Onset& onset) { onset_ = onset; }
  double onset_t_s() const { return onset_t_s_; }  ///< by the detector
  std::size_t since_alarm() const { return since_alarm_; }

 private:
  std::vector<Sample> history_;
  std::vector<Sample> segment_;  ///< history and everything since the alarm
  std::size_t alarm_at_ = 0;     ///< in segment_
  std::size_t fit_from_ = 0;     ///< in segment_
  std::size_t since_alarm_ = 0;
  std::size_t next_fit_ = 0;
  double onset_t_s_ = 0.0;
  std::optional<Onset> onset_;  ///< by the fits, while the segment reached back to it
  bool onset_gone_ = false;     ///< from the segment
};

}  // namespace faultlab::core
