#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "core/filter/impulses.h"
#include "core/filter/observation.h"
#include "core/isolation/fit_context.h"
#include "core/isolation/hypothesis.h"
#include "core/isolation/isolation_task.h"

namespace faultlab::core {

// Counts of samples are for 100 Hz; faster records use more samples for the same time (SpanOf).

/// When one value does not explain the stretch, its newest part may still follow one.
inline constexpr std::size_t kLateSamples = 200;
/// Between the history that is surely healthy and the first sample that is surely faulty.
inline constexpr std::size_t kHistoryGap = 50;

/// The readings of a task as hypotheses are fitted to them. Impulses are left out: before the fault
/// by the calibrated rig, after it by the component that comes nearest, which no single reading
/// decides. Spans stay valid as long as this object; what is left out changes in place.
class CleanReadings {
 public:
  /// @param components  that may have failed, in the order in which they are tried
  CleanReadings(const IsolationTask& task, const std::vector<Component>& components);
  CleanReadings(const CleanReadings&) = delete;
  CleanReadings& operator=(const CleanReadings&) = delete;

  std::span<const Observation> all() const { return readings_; }
  /// The newest since the fault: at most 1200 (at 100 Hz), shared among the channels.
  std::span<const Observation> stretch() const;
  std::span<const Observation> since_fault() const { return all().subspan(fit_from_); }
  /// What certainly lies before the fault; empty if it is too short to tell anything, or not
  /// healthy.
  std::span<const Observation> history() const;

  /// Leaves out what the calibration has shown, if it has shown impulses.
  /// @param nominal  of stretch()
  void LeaveOutKnown(const FitContext& nominal);
  /// Impulses may be so rare that the healthy stretch had none: leaves out what is so far that
  /// nothing else can be behind it.
  /// @param nearest  what comes nearest to stretch(), if that is known already
  /// @param newest   the same of the newest kLateSamples
  /// @returns whether there was any
  bool LeaveOutRare(const FitContext& nominal,
                    const HypothesisFit* nearest,
                    const HypothesisFit* newest);
  /// Takes out the hum that is left since the fault under the component that comes nearest: nobody
  /// could follow it from then on.
  /// @returns whether there was any
  bool TakeOutHum(const FitContext& nominal);
  /// @returns whether LeaveOutRare has left out a reading of this sample
  bool HasLeftOut(std::size_t at) const;
  /// Undoes LeaveOutRare or TakeOutHum, whichever has run last.
  void PutBack();

  /// `context` with its newest readings alone. Of a record that moves, no component comes near the
  /// whole: there, impulses hide behind what it leaves. In the newest part they stand out again.
  /// @param nearest  to them, if that is known already
  FitContext Newest(const FitContext& context,
                    std::size_t samples,
                    const HypothesisFit* nearest = nullptr);

 private:
  std::size_t LeaveOut(const FitContext& context,
                       std::span<Observation> readings,
                       const ImpulseRule& rule,
                       const HypothesisFit* nearest = nullptr) const;
  /// The rig with the component that comes nearest.
  PredictionModel Nearest(const FitContext& context) const;

  const IsolationTask& task_;
  const std::vector<Component>& components_;
  std::vector<double> t_s_;  ///< of readings_
  std::vector<Observation> readings_;
  std::size_t fit_from_ = 0;
  std::optional<ImpulseRule> in_newest_;         ///< what is left out of a newest part
  std::deque<std::vector<Observation>> newest_;  ///< such parts
  std::size_t left_out_of_newest_ = 0;
  std::vector<Observation> before_;
};

}  // namespace faultlab::core
