#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/diagnosis/pipeline.h"
#include "hardware/rig.h"
#include "server/clock.h"
#include "server/run/command_worker.h"
#include "server/run/diagnosis_worker.h"
#include "server/run/recorder.h"
#include "server/run/run_manager.h"
#include "server/run/run_messages.h"
#include "server/run/verdict_teller.h"
#include "server/run/waiting_changes.h"
#include "server/story/run_story.h"
#include "server/stream/stream_hub.h"

namespace faultlab::server {

/// Counted by the run threads, read by /metrics.
struct SharedRunCounters {
  std::atomic<std::uint64_t> started{0}, samples{0}, overruns{0}, gaps{0}, solver_tasks{0};
  std::array<std::atomic<std::uint64_t>, 5> ended{};
};

/// What all runs share.
struct RunServices {
  RecordingStore& store;
  Recorder& recorder;
  DiagnosisWorker& solver;
  CommandWorker& commands;  ///< runs live commands, so that only its thread waits for slow rigs
  StreamHub& hub;
  const Clock& clock;
  SharedRunCounters* counters;
  RunTap* tap = nullptr;
  double speed = 1.0;
  std::function<void(std::string_view)> log;
  decltype(RunManagerOptions::complete) complete;
  decltype(RunManagerOptions::calibrated) calibrated;
  decltype(RunManagerOptions::moment) moment{};
};

/// One experiment from its start to its stored end, on its own thread. The rig is safe before the
/// run reports its end, whatever the reason.
class Run : public std::enable_shared_from_this<Run> {
 public:
  /// `request.hold` has an armed rig; the recording has been begun.
  Run(RunServices services, RunRequest request, RunRecord record, CommandHandler on_command);
  ~Run();  ///< stops and waits
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  core::Status Start();
  void Stop(std::string_view reason);
  core::Result<Accepted> Command(hardware::Epoch epoch, const hardware::RigCommand& command);
  /// The diagnosis starts anew with the next samples: a spoilt stretch need not spoil the run. All
  /// components must be nominal, and stay so until the end of the stretch, to which changes wait.
  core::Result<Accepted> LearnAgain();
  RunSnapshot Snapshot() const;
  hardware::Epoch epoch() const { return epoch_; }
  const core::Bench& bench() const { return *request_.diagnosis.bench; }
  bool ended() const { return ended_.load(); }
  void Wait() const { ended_.wait(false); }

 private:
  void Main();
  void LetGo();
  void Drain();  ///< runs until the end of the rig's stream
  void OnSample(const core::Sample& sample);
  void OnRigEvent(const hardware::RigEvent& event);
  void ExchangeTasks();
  bool Leaving() const;
  void FollowVerdict();
  void FollowLearning();
  void FollowControl();
  void Order(const hardware::RigCommand& command);
  void NoteFaulty();
  void RestartLearning(double next_t_s);
  void ReleaseChanges();
  void ApplyWaitingChanges();  ///< on the thread of the commands, or of the run in simulated time
  core::Result<Accepted> Defer(const hardware::RigCommand& change);
  void TellChanges();
  void AddEvent(RecordedEvent event);
  /// The message with the story, if that is another one than was told last.
  std::string WithStory(std::string message);
  void TellMoment(std::int64_t index, std::string_view why) const;
  bool IsPresent(std::int64_t index) const;
  void FlushRows();
  void FlushRecording(bool all);
  void PublishReadout();
  void FollowLink();
  void Fail(const std::string& reason);
  void Finish();
  void StoreOptions();
  core::Status StoreEnd(const RunEnd& end, const std::string& text, core::VerdictKind verdict);
  RunState EndState() const;
  void Complete(core::Diagnosis& diagnosis);
  std::string Hello();

  RunServices services_;
  RunRequest request_;
  const std::shared_ptr<hardware::Rig> rig_;
  const hardware::Epoch epoch_;
  CommandHandler on_command_;
  core::Pipeline pipeline_;
  const std::string id_;
  const bool real_time_;  ///< a slow reader fails the run; otherwise the rig waits
  const int rows_per_frame_;
  const int samples_per_chunk_;

  // Used by the run's thread only.
  std::unique_ptr<RunTapStream> tap_;  ///< may be null
  std::vector<StreamRow> rows_;
  std::int64_t rows_first_ = 0;
  std::vector<core::Sample> unsaved_samples_;
  std::vector<RecordedEvent> unsaved_events_;
  std::optional<core::Frame> last_frame_;
  MonotonicTime last_readout_{};
  MonotonicTime last_save_{};
  std::uint64_t verdict_seen_ = 0;
  std::uint64_t verdict_sent_ = 0;
  std::uint64_t ordered_ = 0;  ///< the verdict that the rig's speed control has
  MonotonicTime verdict_sent_at_{};
  std::shared_ptr<SolverBox> box_;
  std::uint64_t solver_tasks_ = 0;
  std::string failure_;                ///< why the run fails; empty if it does not
  bool tripped_ = false;               ///< an interlock acted
  lab::SessionId revoked_{};           ///< the session whose end stopped it
  hardware::LoopQuality loop_before_;  ///< of the rig, when the run began
  std::chrono::steady_clock::time_point listened_at_{};  ///< when the link was last looked at
  std::optional<double> silent_s_;  ///< so long the rig has not been heard; nothing: it is heard
  bool finished_ = false;
  bool recording_broken_ = false;
  const Positions nominal_positions_;
  Positions positions_;
  std::string verdict_text_;
  VerdictTeller teller_;
  std::vector<StoryEvent> story_events_;
  std::shared_ptr<const core::Diagnosis> found_;  ///< so far
  std::string story_text_;
  core::Learning learning_;
  bool release_due_ = false;  ///< the stretch is over: waiting changes may act

  WaitingChanges waiting_;
  std::atomic<bool> learn_again_{false};
  std::atomic<std::int64_t> next_index_{0};  ///< of the samples, as far as they have come
  bool learnt_again_ = false;                ///< the options differ from the stored ones

  mutable std::mutex mutex_;  ///< guards state_ and faulty_
  std::string faulty_;        ///< components that are not nominal, or not confirmed: "R1, R12"
  RunSnapshot state_;
  std::mutex control_mutex_;  ///< held while a command, stop or release goes to the rig
  bool rig_is_ours_ = true;   ///< guarded by it; after LetGo another lease may have the rig
  std::atomic<bool> stopped_by_us_{false};
  std::atomic<bool> stopped_by_owner_{false};
  std::atomic<bool> stopped_by_another_{false};
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace faultlab::server
