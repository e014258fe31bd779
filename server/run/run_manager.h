#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/types/result.h"
#include "hardware/rig.h"
#include "hardware/run_plan.h"
#include "server/clock.h"
#include "server/run/rig_pool.h"
#include "server/storage/recording_store.h"
#include "server/stream/stream_hub.h"

namespace faultlab::server {

/// Sends one run's data to a receiver other than the viewers (the LCM tap). Called on the run's
/// thread: must not block.
class RunTapStream {
 public:
  virtual ~RunTapStream() = default;
  virtual void OnFrame(const core::Frame& frame) = 0;
  virtual void OnEvent(const hardware::RigEvent& event, double t_s) = 0;
};

class RunTap {
 public:
  virtual ~RunTap() = default;
  virtual std::unique_ptr<RunTapStream> Open(const std::string& rig,
                                             const std::string& run,
                                             hardware::Epoch epoch) = 0;
};

/// The reason of a stop that the run's owner asked for, and of one that somebody else did who may;
/// all others are the lab's.
inline constexpr std::string_view kStoppedByOwner = "stopped by a person";
inline constexpr std::string_view kStoppedByAnother = "stopped by another person";

/// How a sealed run has ended.
struct SealedEnd {
  RunState state{};
  bool tripped = false;      ///< an interlock of the rig ended it
  bool by_owner = false;     ///< stopped by its owner
  bool by_another = false;   ///< stopped by somebody else
  lab::SessionId revoked{};  ///< the session whose end stopped it; 0: none
  double length_s = 0.0;     ///< that was recorded
};

/// Keeps what tells the faults of a sealed run: its stored plan lacks them, its events of
/// components go here and nowhere else, it has no diagnosis and takes no command. Called on the
/// run's thread.
class SealedWitness {
 public:
  virtual ~SealedWitness() = default;
  virtual void OnEvent(const hardware::RigEvent& event, double period_s) = 0;
  /// Before the end is stored, so that a run with a stored end has its witness's account.
  virtual void OnEnd(const SealedEnd& end) = 0;
};

/// One experiment, validated and resolved.
struct RunRequest {
  std::string name;
  std::string owner;      ///< Principal::owner_key()
  std::string plan_json;  ///< the resolved plan as the API shows it, one JSON object
  hardware::RunPlan plan;
  RigHandle hold;                            ///< of the rig on which it runs
  bool hidden_faults = false;                ///< true: nothing is sent to the tap
  core::DiagnosisOptions diagnosis;          ///< stored with the run; the period is the plan's
  std::shared_ptr<void> place{};             ///< of RunQuota; released when the run has ended
  std::shared_ptr<SealedWitness> witness{};  ///< not null: the run is sealed
};

/// What is known of a running run.
struct RunSnapshot {
  std::string id;
  std::string name;
  std::string owner;
  std::string rig;
  std::string bench;  ///< core::Bench::id
  hardware::Epoch epoch{};
  RunState state = RunState::kRunning;
  std::string plan_json;
  WallTime created_at{};
  MonotonicTime began{};
  bool on_rig = true;  ///< false: the rig may have gone to another run already
  std::int64_t samples = 0;
  double period_s = 0.01;
  std::vector<RecordedEvent> events;
  std::string verdict;         ///< the kind of the verdict
  std::string diagnosis_json;  ///< so far
  /// The diagnosis that `verdict` belongs to, without the estimates of later samples; null before
  /// the first one.
  std::shared_ptr<const core::Diagnosis> diagnosis{};
};

/// What a run has learnt about the rig that it ran on.
struct LearntRig {
  const std::string& rig;
  const std::string& run;
  const std::string& owner;      ///< of the run
  std::span<const double> uc_v;  ///< of the stretch that it was learnt from
  const core::Bench& bench;
  const core::Calibration& calibration;
};

/// Something of a run that a picture of the bench is worth.
struct RunMoment {
  const std::string& run;
  const std::string& rig;
  std::int64_t index = 0;  ///< of the sample
  std::string_view why;    ///< "fault": one was switched; "detection"; "end"
};

struct RunManagerOptions {
  std::string server_id = "local";
  double speed = 1.0;  ///< of the simulated rigs: frames are batched to 20 a second of wall time
  /// Adds those parts of an ended run's diagnosis that need the whole recording (fits of models).
  /// May be empty. Called on the run's thread.
  std::function<void(
      std::span<const core::Sample>, const core::DiagnosisOptions&, core::Diagnosis&)>
      complete;
  /// Never of a replay. May be empty. Called on the run's thread, after its end is stored.
  std::function<void(const LearntRig& learnt)> calibrated;
  /// May be empty. Called on the run's thread: must not block.
  std::function<void(const RunMoment& moment)> moment{};
  /// Where runs keep what the database does not take for a time: see Backlog. Empty: nowhere.
  std::string backlog_folder{};
  /// Whether the disk has room for more samples; without it a recording ends. May be empty. Any
  /// thread.
  std::function<core::Status()> room{};
  /// How long Shutdown waits for a database that is away.
  std::chrono::milliseconds leave_after{5000};
};

struct RunCounters {
  std::uint64_t started = 0;
  std::uint64_t ended[5] = {};  ///< by RunState
  std::uint64_t samples = 0;
  std::uint64_t overruns = 0;
  std::uint64_t gaps = 0;
  std::uint64_t solver_tasks = 0;  ///< of runs that have ended: before that it would tell a fault
};

/// Runs experiments: plan -> rig -> its own drain thread -> pipeline -> viewers and recording.
///
///   rig thread --RigMessage--> [run thread] Pipeline.Push --Frame--> StreamHub
///                                   |  samples, events --> [recorder thread] --> RecordingStore
///                                   +-- isolation tasks --> [solver thread]
///
/// Whatever ends a run (plan complete, stop, trip, a full queue, a programming error), it ends with
/// SafeStop and a stored state. A slow, dead or hostile viewer does not affect the run thread.
class RunManager {
 public:
  RunManager(RunManagerOptions options,
             RecordingStore& store,
             StreamHub& hub,
             const Clock& clock,
             std::function<void(std::string_view)> log);
  ~RunManager();
  RunManager(const RunManager&) = delete;
  RunManager& operator=(const RunManager&) = delete;

  /// May be null. To be called before the first Start.
  void SetTap(RunTap* tap);
  /// Sets the check before each live command: whether this process may still drive rigs. To be
  /// called before the first Start.
  void SetGuard(std::function<bool()> in_force);

  /// `told` hears of each run that its owner's viewer stops. To be called before the first Start.
  void OnOwnersStop(std::function<void(const RunSnapshot&)> told);

  /// Arms, records, starts. kStale when the lease has ended meanwhile.
  core::Result<RunSnapshot> Start(RunRequest request);
  /// The rig becomes safe; the run ends as `stopped` within a moment. kNotFound; kConflict when it
  /// has ended.
  core::Status Stop(std::string_view id, std::string_view reason);
  /// Acts at the rig's next tick. A change that comes during the calibration of the healthy rig
  /// waits for the end of that stretch; the answer contains the time. kStale when the epoch is not
  /// the run's.
  core::Result<Accepted> Command(std::string_view id,
                                 hardware::Epoch epoch,
                                 const hardware::RigCommand& command);

  /// The run learns its healthy rig again from now on; the answer contains the end of the stretch.
  /// kNotFound; kConflict when it cannot, with the reason.
  core::Result<Accepted> LearnAgain(std::string_view id);

  /// A running run, or one that ended a moment ago. Older runs are in the RecordingStore.
  std::optional<RunSnapshot> Find(std::string_view id) const;
  std::vector<RunSnapshot> Running() const;
  /// Blocks until the run has ended and is stored. For tests and jobs.
  void Wait(std::string_view id);
  /// Stores what former processes of this server could not. To be called when their runs have been
  /// marked as interrupted, and before the first Start.
  core::Status StoreBacklogs();
  /// Stops every run and waits for their recordings; for a database that is away only a moment:
  /// the next start stores the rest.
  void Shutdown();

  RunCounters counters() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace faultlab::server
