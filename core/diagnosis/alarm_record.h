#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/detection/detector.h"
#include "core/isolation/isolation.h"
#include "core/types/sample.h"
#include "core/types/time_span.h"

namespace faultlab::core {

/// The samples that a fit needs. Without an alarm: the newest samples. After an alarm: the history
/// before it and everything since. Bounded: at most some 2600 samples, or 26 s of a record faster
/// than 100 Hz.
class AlarmRecord {
 public:
  explicit AlarmRecord(double period_s = 0.01);

  /// A sample without an alarm.
  void Remember(const Sample& sample);
  /// A sample after the alarm.
  void Append(const Sample& sample);

  /// The newest sample has raised `alarm`. `alarmed`: an earlier alarm was still open.
  void Open(const Alarm& alarm, bool alarmed);
  /// The alarm is withdrawn: its newest samples become history again.
  void Close();

  /// True at the samples after the alarm at which the hypotheses are to be fitted.
  bool FitIsDue() const { return since_alarm_ >= next_fit_; }
  void ScheduleNextFit();
  /// Nothing can be told yet. In the first ten seconds the next fit is then due within a second: a
  /// part that moves may have come to rest.
  void FitSoon();
  /// Nothing explains the samples from the estimated onset on, which may be too early. Those from
  /// the alarm on certainly belong to the fault.
  void FitFromAlarm() { fit_from_ = std::max(fit_from_, alarm_at_); }
  /// As many samples have followed the alarm as the first fit needs.
  bool HasBeenFitted() const;

  /// Drops samples that are too old, and fills samples, alarm_at, fit_from and settled; also onset,
  /// once the onset lies before the samples.
  void Fill(IsolationTask& task);

  /// Stores the onset that a fit has found. Until then the detector's estimate is used.
  void SetOnset(const Onset& onset) { onset_ = onset; }
  double onset_t_s() const { return onset_t_s_; }  ///< estimated by the detector
  std::size_t since_alarm() const { return since_alarm_; }

 private:
  std::size_t Span(std::size_t samples) const { return SpanOf(samples, period_s_); }
  std::vector<Sample> Newest(const std::vector<Sample>& samples) const;

  double period_s_;
  std::vector<Sample> history_;
  std::vector<Sample> segment_;  ///< history and everything since the alarm
  std::size_t alarm_at_ = 0;     ///< in segment_
  std::size_t fit_from_ = 0;     ///< in segment_
  std::size_t since_alarm_ = 0;
  std::size_t next_fit_ = 0;
  double onset_t_s_ = 0.0;
  std::optional<Onset> onset_;  ///< from the fits, set while the segment still contained it
  bool onset_gone_ = false;     ///< it is no longer in the segment
};

}  // namespace faultlab::core
