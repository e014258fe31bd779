#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/detection/detector.h"
#include "core/diagnosis/alarm_record.h"
#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/diagnosis/fault_episodes.h"
#include "core/filter/hum_tracker.h"
#include "core/filter/observation.h"
#include "core/isolation/isolation.h"
#include "core/types/calibration.h"
#include "core/types/frame.h"
#include "core/types/sample.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// Watches a calibrated rig: detects a change, has it worked out, and says what is known of it.
///
///   Sample --Push--> Detector --alarm--> TakeTask --IsolationTask--> Isolate (any thread)
///                       ^                                               |
///                       +---- reference model ---- Accept <-------------+--> verdict()
///
/// A fault is watched as soon as it is known and stands: the detector's model carries it. One that
/// has come as a drift, or has been found with a third value in one direction, moves: its further
/// alarms are not told, only where it is.
class RigWatch {
 public:
  /// @param options  outlive this object
  /// @param calibration  never null; hum in it has the phase that it has in this run
  /// @param next_id  of the first task
  RigWatch(const DiagnosisOptions& options,
           std::shared_ptr<const Calibration> calibration,
           std::uint64_t next_id);

  void Push(const Sample& sample);
  /// What is to be worked out, if there is anything; a newer one replaces one not yet taken.
  std::optional<IsolationTask> TakeTask();
  /// Results of alarms that are no longer open have no effect.
  /// @param frame  the newest, of which the paper's path is told
  void Accept(IsolationResult&& result, const Frame& frame);
  /// No sample follows: answers what is open with all data.
  void Finish(const Frame& frame);

  const Verdict& verdict() const { return verdict_; }
  /// From 1; increases whenever verdict() changes.
  std::uint64_t verdict_version() const { return version_; }
  const std::vector<FaultEpisode>& episodes() const { return episodes_.list(); }
  std::uint64_t next_id() const { return next_id_; }
  /// Of the rig's noise, learnt where the calibration's is to be expected.
  const NoiseScale& noise_scale() const { return noise_scale_; }

 private:
  // A rig as far as it is known.
  struct KnownRig {
    std::vector<double> shift;  // of the calibration's coordinates: all of them, or none
    double direct_factor = 1.0;
    std::vector<Candidate> faults;
    std::vector<Component> alike;  // what nothing told apart from the last of them
    // So many alarms in a row have found the last of them farther up (> 0) or farther down (< 0).
    int steps = 0;
    bool has_moved = false;     // the last of them, and may again
    double noise_factor = 1.0;  // how many times the calibration's noise is to be expected
  };

  // The newest alarm, until it is withdrawn.
  struct OpenAlarm {
    KnownRig before;  // carried by the detector's model when it was raised
    double t_s;
    std::string detector;
    // As in IsolationTask.
    std::vector<Component> found_turning = {};
    std::vector<Component> alike_at_rest = {};
    std::vector<Candidate> found = {};
    bool found_moving = false;  // found_turning is of a fault that moved
    // Of a detector that knows no impulses, on a rig without a fault that may have gone.
    bool one_reading = false;
    bool held_back = false;  // not published yet
    // Of accumulated evidence, and being worked out: only what is far off by itself is another.
    bool only_sharp = false;
  };

  void Publish(Verdict next);
  /// @param samples  after which it is known so
  void Watch(KnownRig rig, int samples);
  bool TakesThePlace(const Alarm& alarm) const;
  void OnAlarm(const Alarm& alarm, const Sample& sample);
  IsolationTask MakeTask();
  /// KnownRig::steps after that answer.
  int StepsTo(const std::vector<Candidate>& present) const;
  void TellEarly(IsolationResult&& result, const Frame& frame);
  void Remember(const IsolationResult& result, const Verdict& next);
  void WatchOn(const IsolationResult& result, const Verdict& next);
  bool MayBeWithdrawn(bool settled, double gain) const;
  bool KnowsImpulses() const;
  void ReturnToNominal(const Verdict& last, const std::vector<double>& shift);
  Verdict AlarmVerdict() const;

  const DiagnosisOptions& options_;
  const std::shared_ptr<const Calibration> calibration_;
  ObservationBuilder builder_;
  AlarmRecord record_;
  std::optional<Detector> detector_;
  std::optional<HumTracker> hum_;
  NoiseScale noise_scale_;  // outlives the detectors that learn it
  bool detector_fresh_ = false;
  std::optional<IsolationTask> pending_;
  std::uint64_t next_id_;
  std::uint64_t oldest_valid_id_;
  KnownRig watched_;  // carried by the detector's model
  std::optional<OpenAlarm> alarm_;
  FaultEpisodes episodes_;
  // It has been found to warm up, or a small change has come to nothing.
  bool doubts_small_ = false;
  bool impulse_seen_ = false;  // one reading has raised an alarm, and nothing was behind it
  Verdict verdict_;
  std::uint64_t version_ = 0;
};

}  // namespace faultlab::core
