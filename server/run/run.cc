#include "server/run/run.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>
#include <variant>

namespace faultlab::server {
namespace {

constexpr std::chrono::milliseconds kReadPatience{20};
constexpr std::chrono::milliseconds kReadoutInterval{200};
constexpr std::chrono::milliseconds kSaveInterval{1000};  ///< the most that a crash can lose
constexpr std::chrono::seconds kSilentAfter{2};
constexpr double kChunkSeconds = 1.0;
constexpr double kFrameSeconds = 0.05;
constexpr double kPresentSeconds = 3.0;
constexpr int kRowsPerFrameMax = 250;
constexpr std::size_t kEventsShownMax = 1000;

/// As RunManagerOptions::speed; a far rig keeps its own.
double SpeedOf(const RigHandle& hold, double speed) {
  if (hold.pace() == Pace::kFastest) return 0.0;
  return hold.rig().description().kind == hardware::RigKind::kRemote ? 1.0 : speed;
}

/// 20 frames a second of wall time, whatever the speed and the period; one of a sample on a slow
/// bench.
int RowsPerFrame(double speed, double period_s) {
  if (speed <= 0.0) return kRowsPerFrameMax;
  const double rows = std::round(kFrameSeconds / period_s * speed);
  return std::clamp(static_cast<int>(rows), 1, kRowsPerFrameMax);
}

/// End of the stretch in which changes wait. A replay refuses all changes itself.
std::optional<double> LearningEnd(const RunRequest& request,
                                  core::Learning learning,
                                  const hardware::RigDescription& rig) {
  const bool waits = learning == core::Learning::kStretch && !request.witness &&
                     rig.kind != hardware::RigKind::kReplay;
  return waits ? std::optional(request.diagnosis.healthy_to_s) : std::nullopt;
}

}  // namespace

Run::Run(RunServices services, RunRequest request, RunRecord record, CommandHandler on_command)
    : services_(std::move(services)),
      request_(std::move(request)),
      rig_(request_.hold.shared_rig()),
      epoch_(request_.hold.epoch()),
      on_command_(std::move(on_command)),
      pipeline_(request_.diagnosis),
      id_(record.id),
      real_time_(SpeedOf(request_.hold, services_.speed) == 1.0),
      rows_per_frame_(RowsPerFrame(SpeedOf(request_.hold, services_.speed), record.period_s)),
      samples_per_chunk_(
          std::max(1, static_cast<int>(std::lround(kChunkSeconds / record.period_s)))),
      box_(std::make_shared<SolverBox>()),
      nominal_positions_(NominalPositions(*request_.diagnosis.bench, request_.diagnosis.nominal)),
      positions_(nominal_positions_),
      teller_(record.period_s),
      learning_(pipeline_.learning()),
      waiting_(LearningEnd(request_, learning_, rig_->description())) {
  state_.id = record.id;
  state_.name = record.name;
  state_.owner = record.owner;
  state_.rig = record.rig;
  state_.bench = record.bench;
  state_.epoch = epoch_;
  state_.plan_json = record.plan_json;
  state_.created_at = record.created_at;
  state_.began = services_.clock.Monotonic();
  state_.period_s = record.period_s;
  state_.verdict = core::Name(pipeline_.verdict().kind);
  verdict_text_ = VerdictText(pipeline_.verdict());
  state_.diagnosis_json = verdict_text_;
  found_ = std::make_shared<const core::Diagnosis>();
  story_text_ = StoryText({});
  // What is played faster than time would fill the bus that real rigs use.
  if (services_.tap != nullptr && !request_.hidden_faults && request_.hold.pace() == Pace::kOfRig)
    tap_ = services_.tap->Open(record.rig, id_, epoch_);
}

Run::~Run() {
  Stop("the server forgets the run");
  if (thread_.joinable()) thread_.join();
}

core::Status Run::Start() {
  loop_before_ = rig_->loop_quality();
  TRY_DONE(rig_->Start(epoch_));
  services_.hub.OpenChannel({.run = id_,
                             .started = services_.clock.Monotonic(),
                             .on_command = on_command_,
                             .brief = request_.hold.pace() == Pace::kFastest},
                            Hello());
  thread_ = std::thread([this] { Main(); });
  return core::Done{};
}

void Run::Stop(std::string_view reason) {
  const std::lock_guard lock(control_mutex_);
  if (!rig_is_ours_) return;
  if (!stopped_by_us_) {  // the first one counts
    stopped_by_owner_ = reason == kStoppedByOwner;
    stopped_by_another_ = reason == kStoppedByAnother;
  }
  stopped_by_us_ = true;
  rig_->SafeStop(reason);
}

RunSnapshot Run::Snapshot() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

std::string Run::Hello() {
  std::vector<RecordedEvent> events;
  RunState state = RunState::kRunning;
  {
    const std::lock_guard lock(mutex_);
    events = state_.events;
    state = state_.state;
  }
  return HelloMembers({id_,
                       request_.diagnosis.bench->id,
                       state,
                       epoch_,
                       1.0 / state_.period_s,
                       state_.plan_json,
                       positions_,
                       events,
                       verdict_text_,
                       story_text_,
                       learning_ == core::Learning::kStretch && !request_.witness
                           ? std::optional(request_.diagnosis.healthy_to_s)
                           : std::nullopt,
                       waiting_.values(),
                       request_.diagnosis.nominal,
                       rig_->description().delta_s});
}

void Run::Main() {
  try {
    Drain();
  } catch (const std::exception& error) {
    Fail(std::string("The server made a mistake: ") + error.what());
  }
  LetGo();
  try {
    Finish();
  } catch (const std::exception& error) {
    services_.log("run " + id_ + ": could not be finished: " + error.what());
    services_.hub.CloseChannel(id_, EndText(RunState::kFailed), {});
    const std::lock_guard lock(mutex_);
    state_.state = RunState::kFailed;
  }
  ended_ = true;
  ended_.notify_all();
}

/// Releases the rig for the next lease before the recording is finished.
void Run::LetGo() {
  rig_->SafeStop("the run has ended");
  // The next run may begin now, although this object exists until ended runs are collected.
  request_.place.reset();
  {
    const std::lock_guard lock(mutex_);
    state_.on_rig = false;
  }
  RigHandle hold;
  {
    const std::lock_guard lock(control_mutex_);
    rig_is_ours_ = false;
    hold = std::move(request_.hold);
  }
}

void Run::Drain() {
  std::vector<hardware::RigMessage> messages;
  bool rig_told = false;
  for (;;) {
    messages.clear();
    const hardware::ReadStatus status = rig_->Read(messages, kReadPatience);
    TellChanges();  // before the rig's answers to them
    for (const hardware::RigMessage& message : messages) {
      if (const auto* sample = std::get_if<core::Sample>(&message)) {
        OnSample(*sample);
      } else {
        OnRigEvent(std::get<hardware::RigEvent>(message));
      }
    }
    if (release_due_) ReleaseChanges();
    const MonotonicTime now = services_.clock.Monotonic();
    if (now - last_readout_ >= kReadoutInterval) {
      last_readout_ = now;
      PublishReadout();
      FollowVerdict();
      FollowLink();
    }
    if (now - last_save_ >= kSaveInterval) {
      last_save_ = now;
      FlushRecording(true);
    }
    if (status == hardware::ReadStatus::kEnded) return;
    if (!failure_.empty() && !rig_told) {
      rig_told = true;
      rig_->SafeStop(failure_);
    }
  }
}

void Run::FollowLink() {
  // A process that stood still has not listened: what the rig said meanwhile is read first.
  const auto now = std::chrono::steady_clock::now();
  if (now - std::exchange(listened_at_, now) >= kSilentAfter) return;
  const std::optional<std::chrono::nanoseconds> silence = rig_->silence();
  const bool silent = silence && *silence > kSilentAfter;
  const std::int64_t index = last_frame_ ? last_frame_->sample.index + 1 : 0;
  const std::optional<double> before = silent_s_;
  silent_s_.reset();
  if (silent) silent_s_ = std::chrono::duration<double>(*silence).count();
  if (silent && !before) AddEvent(MakeLinkEvent("rig_silent", index, state_.period_s, {}));
  if (!silent && before) AddEvent(MakeLinkEvent("rig_heard", index, state_.period_s, before));
}

void Run::OnSample(const core::Sample& sample) {
  ExchangeTasks();
  if (learn_again_) RestartLearning(sample.t_s);
  next_index_ = sample.index + 1;
  const core::Frame& frame = pipeline_.Push(sample);
  if (!last_frame_) last_readout_ = {};  // of the first sample at once, however long it took
  last_frame_ = frame;
  const std::int64_t expected = rows_first_ + static_cast<std::int64_t>(rows_.size());
  if (!rows_.empty() && sample.index != expected) FlushRows();
  if (rows_.empty()) rows_first_ = sample.index;
  rows_.push_back(MakeRow(frame));
  unsaved_samples_.push_back(sample);
  if (tap_ != nullptr) tap_->OnFrame(frame);
  if (static_cast<int>(rows_.size()) >= rows_per_frame_) FlushRows();
  if (static_cast<int>(unsaved_samples_.size()) >= samples_per_chunk_) FlushRecording(false);
  if (pipeline_.verdict_version() != verdict_seen_) FollowVerdict();
  if (pipeline_.learning() != learning_) FollowLearning();
  if (request_.plan.control) FollowControl();
}

void Run::ExchangeTasks() {
  if (auto result = box_->Take()) pipeline_.Accept(std::move(*result));
  while (!Leaving()) {
    std::optional<core::DiagnosisTask> task = pipeline_.TakeTask();
    if (!task) return;
    ++solver_tasks_;
    if (real_time_) return services_.solver.Submit(std::move(*task), box_);
    // Simulated time stands still meanwhile, so that verdicts fall on the same samples each time.
    pipeline_.Accept(Solve(*task));
    rig_->KeepAlive(epoch_);
  }
}

/// The run was stopped or its lease has ended: it waits for no fit of another run.
bool Run::Leaving() const {
  return stopped_by_us_ || request_.hold.revoked();
}

void Run::FollowVerdict() {
  const core::Verdict& verdict = pipeline_.verdict();
  if (pipeline_.verdict_version() != verdict_seen_) {
    verdict_seen_ = pipeline_.verdict_version();
    const std::int64_t now = last_frame_ ? last_frame_->sample.index : 0;
    verdict_text_ = VerdictText(verdict);
    found_ = std::make_shared<const core::Diagnosis>(pipeline_.Snapshot());
    {
      const std::lock_guard lock(mutex_);
      state_.verdict = core::Name(verdict.kind);
      state_.diagnosis_json = verdict_text_;
      state_.diagnosis = found_;
    }
    for (RecordedEvent& event : teller_.Hear(verdict, now)) {
      const bool detected = event.kind == "detected";
      AddEvent(std::move(event));
      if (detected && IsPresent(now)) TellMoment(now, "detection");
    }
  }
  const MonotonicTime now = services_.clock.Monotonic();
  if (verdict_sent_ != verdict_seen_ && now - verdict_sent_at_ >= kReadoutInterval) {
    verdict_sent_ = verdict_seen_;
    verdict_sent_at_ = now;
    std::string text = WithStory(verdict_text_);
    services_.hub.PublishText(id_, std::move(text), Hello());
  }
}

std::string Run::WithStory(std::string message) {
  std::string story = StoryText(TellStory(story_events_, *found_, state_.period_s), kStoryLiveMost);
  if (story == story_text_) return message;
  story_text_ = std::move(story);
  message.back() = ',';
  return message.append("\"story\":").append(story_text_).append("}");
}

void Run::OnRigEvent(const hardware::RigEvent& event) {
  if (request_.witness && event.component.exists()) {
    request_.witness->OnEvent(event, state_.period_s);
    return;
  }
  Follow(positions_, event, nominal_positions_);
  NoteFaulty();
  if (event.kind == hardware::RigEventKind::kTrip) {
    services_.log("run " + id_ + ": interlock of rig " + rig_->description().id + ": " +
                  event.text);
    tripped_ = true;
    if (failure_.empty()) failure_ = "Interlock: " + event.text;
  } else if (event.kind == hardware::RigEventKind::kFinished) {
    finished_ = true;
  } else if (event.kind == hardware::RigEventKind::kStopped && request_.hold.revoked()) {
    stopped_by_us_ = true;  // the pool stopped it, at the end of the session
    revoked_ = request_.hold.lease().session;
  } else if (event.kind == hardware::RigEventKind::kStopped && !stopped_by_us_ &&
             failure_.empty()) {
    failure_ = event.text;
  } else if (event.kind == hardware::RigEventKind::kOverrun) {
    ++services_.counters->overruns;
  } else if (event.kind == hardware::RigEventKind::kGap) {
    ++services_.counters->gaps;
  }
  if (tap_ != nullptr) {
    tap_->OnEvent(event, static_cast<double>(event.index) * state_.period_s);
  }
  const bool last = event.kind == hardware::RigEventKind::kFinished ||
                    event.kind == hardware::RigEventKind::kStopped;
  if (last || event.kind == hardware::RigEventKind::kTrip) waiting_.End();
  const hardware::LoopQuality loop =
      last ? rig_->loop_quality().Since(loop_before_) : hardware::LoopQuality{};
  AddEvent(MakeEvent(event, state_.period_s, last ? &loop : nullptr));
  if (last) TellMoment(last_frame_ ? last_frame_->sample.index : 0, "end");
  if (event.kind == hardware::RigEventKind::kRelayConfirmed && event.component.exists() &&
      event.value != request_.diagnosis.nominal.Get(event.component) && IsPresent(event.index)) {
    TellMoment(event.index, "fault");
  }
}

void Run::TellMoment(std::int64_t index, std::string_view why) const {
  if (services_.moment) services_.moment({id_, state_.rig, index, why});
}

/// False for what a far rig tells late, after a cut of its link: a picture would show another time.
bool Run::IsPresent(std::int64_t index) const {
  const std::chrono::duration<double> elapsed = services_.clock.Monotonic() - state_.began;
  return !real_time_ ||
         elapsed.count() - static_cast<double>(index) * state_.period_s < kPresentSeconds;
}

void Run::AddEvent(RecordedEvent event) {
  FlushRows();  // viewers get the samples before the events on them
  std::string text = event.json;
  if (const auto told = ToStoryEvent(event, bench())) {
    story_events_.push_back(*told);
    text = WithStory(std::move(text));
  }
  unsaved_events_.push_back(event);
  {
    const std::lock_guard lock(mutex_);
    if (state_.events.size() < kEventsShownMax) state_.events.push_back(std::move(event));
  }
  services_.hub.PublishText(id_, std::move(text), Hello());
}

void Run::FlushRows() {
  if (rows_.empty()) return;
  services_.hub.Publish(id_, rows_first_, rows_);
  services_.counters->samples += rows_.size();
  {
    const std::lock_guard lock(mutex_);
    state_.samples += static_cast<std::int64_t>(rows_.size());
  }
  rows_.clear();
}

void Run::FlushRecording(bool all) {
  if (recording_broken_) return;
  const auto when_full = real_time_ ? Recorder::WhenFull::kFail : Recorder::WhenFull::kWait;
  bool ok = true;
  if (all || static_cast<int>(unsaved_samples_.size()) >= samples_per_chunk_) {
    ok = services_.recorder.Append(id_, std::exchange(unsaved_samples_, {}), when_full);
  }
  if (ok) ok = services_.recorder.Append(id_, std::exchange(unsaved_events_, {}), when_full);
  if (ok) return;
  recording_broken_ = true;
  Fail("The recording could not be written, so the run was stopped.");
}

void Run::PublishReadout() {
  if (last_frame_) services_.hub.PublishText(id_, ReadoutText(*last_frame_));
}

void Run::Fail(const std::string& reason) {
  if (!failure_.empty()) return;
  failure_ = reason;
  services_.log("run " + id_ + " fails: " + reason);
}

}  // namespace faultlab::server
