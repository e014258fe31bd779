#include "core/diagnosis/pipeline.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/detection/detector.h"
#include "core/diagnosis/alarm_record.h"
#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/fault_episodes.h"
#include "core/diagnosis/paper_view.h"
#include "core/estimators/estimator_bank.h"
#include "core/filter/hum_tracker.h"
#include "core/filter/observation.h"
#include "core/isolation/fit_context.h"

namespace faultlab::core {
namespace {

// An alarm is withdrawn when no fault explains it. If a fault explains it a little, it may be a
// small fault, and more data is needed first.
constexpr double kWithdrawGain = 8.0;
constexpr std::size_t kWithdrawAfter = 500;
// The detector of small changes, which have been going on for a while when it raises an alarm.
constexpr const char* kOfSeconds = "glr_500";
constexpr const char* kBeingWorkedOut = "something has changed; what, is being worked out";
// Samples kept until the calibration is finished; more than any machine needs for a fit.
constexpr std::size_t kBacklogMax = 3000;
// Samples at the end of the healthy stretch during which the detector settles.
constexpr std::size_t kSettling = 50;

// The calibrated rig with `faults`, its coordinates moved by `shift` (all of them, or none).
RigParameters ReferenceRig(const Calibration& calibration,
                           const std::vector<Candidate>& faults,
                           const std::vector<double>& shift,
                           double period_s) {
  RigParameters rig = ParametersOf(calibration);
  if (!shift.empty()) {
    const auto n = static_cast<Eigen::Index>(shift.size());
    rig = WithOffsets(rig, Eigen::Map<const Eigen::VectorXd>(shift.data(), n), period_s);
  }
  for (const Candidate& fault : faults) rig = WithComponent(rig, fault.component, fault.value);
  return rig;
}

Verdict NominalVerdict(std::string reason) {
  Verdict verdict;
  verdict.kind = VerdictKind::kNominal;
  verdict.settled = true;
  verdict.reason = std::move(reason);
  return verdict;
}

}  // namespace

namespace {

ObservationBuilder MakeBuilder(const DiagnosisOptions& options, const Calibration* calibration) {
  return {options.bench->readings(),
          options.channels,
          options.period_s,
          options.um_rail_v,
          calibration != nullptr ? ZerosOf(*calibration) : ReadingZeros{}};
}

}  // namespace

struct Pipeline::State {
  enum class Phase { kWaiting, kLearning, kCalibrating, kRefused, kWatching, kAlarmed };

  explicit State(DiagnosisOptions o)
      : options(std::move(o)),
        bank(BankOptions(options)),
        builder(MakeBuilder(options, options.calibration ? &*options.calibration : nullptr)),
        record(options.period_s) {
    if (options.calibration) {
      calibration = std::make_shared<const Calibration>(WithHumAsNoise(*options.calibration));
      phase = Phase::kWatching;
      StartWatching({}, {}, calibration->samples);
      SetNominal();
    }
  }

  DiagnosisOptions options;
  EstimatorBank bank;
  ObservationBuilder builder;
  Phase phase = Phase::kWaiting;
  Frame frame;
  Verdict verdict;
  std::uint64_t version = 1;
  std::shared_ptr<const Calibration> calibration;
  std::optional<Error> refusal;

  std::vector<Sample> learning;
  std::vector<Sample> backlog;  // since the end of the healthy stretch, until calibrated
  AlarmRecord record;
  std::optional<Detector> detector;
  std::optional<HumTracker> hum;          // once it is calibrated
  std::optional<NoiseScale> noise_scale;  // outlives the detectors that learn it
  bool detector_fresh = false;
  // While an alarm of accumulated evidence is worked out: only what is far off by itself is
  // another.
  bool only_sharp = false;
  std::optional<DiagnosisTask> pending;
  std::uint64_t next_id = 1;
  std::uint64_t oldest_valid_id = 1;
  std::vector<Candidate> reference;  // faults carried by the model before the present alarm
  std::vector<Candidate> watched;    // faults carried by the detector's model
  double alarm_t_s = 0.0;
  std::string alarm_detector;
  FaultEpisodes episodes;
  bool warms_up = false;      // it has been found to
  bool impulse_seen = false;  // one reading has raised an alarm, and nothing was behind it
  bool held_back = false;     // the newest alarm is not published yet

  // ---- verdicts
  void Publish(Verdict next) {
    verdict = std::move(next);
    ++version;
  }

  void SetNominal() { Publish(NominalVerdict("the record fits the calibrated rig")); }

  // ---- calibration
  CalibrationTask MakeCalibration() {
    CalibrationTask task;
    task.id = next_id++;
    task.samples = learning;
    task.options = CalibrationOf(options);
    return task;
  }

  void Refuse(const Error& error) {
    refusal = error;
    phase = Phase::kRefused;
    Verdict next;
    const bool poor = error.field == "excitation" || error.field == "length";
    next.kind = poor ? VerdictKind::kNotExcited : VerdictKind::kCalibrating;
    next.settled = true;
    next.reason = error.message;
    Publish(std::move(next));
  }

  void Calibrated(std::shared_ptr<const Calibration> learnt) {
    calibration = std::move(learnt);
    phase = Phase::kWatching;
    StartWatching({}, {}, calibration->samples);
    SetNominal();
    // The detector starts on the end of the healthy stretch and judges only what follows.
    const std::vector<Sample> missed = std::move(backlog);
    backlog.clear();
    builder = MakeBuilder(options, calibration.get());
    if (calibration->hum.any())
      hum.emplace(calibration->hum, NoiseOf(*calibration), options.period_s);
    for (const Sample& sample : missed) Watch(sample);
  }

  // ---- watching
  void StartWatching(const std::vector<Candidate>& faults,
                     const std::vector<double>& shift,
                     int samples) {
    if (!noise_scale) noise_scale.emplace(calibration->samples);
    detector.emplace(*options.bench,
                     ReferenceRig(*calibration, faults, shift, options.period_s),
                     DetectionNoiseOf(*calibration),
                     options.period_s,
                     calibration->mask(),
                     calibration->thresholds,
                     samples,
                     *noise_scale,
                     faults.empty() ? 0.0 : options.bench->n.step_s,
                     calibration->impulse_share > 0.0 || impulse_seen);
    detector_fresh = true;
    only_sharp = false;
    watched = faults;
  }

  void Watch(const Sample& as_read) {
    const Sample sample = hum ? hum->Clean(as_read) : as_read;
    Observation observation;
    if (!builder.Push(sample, observation)) return;
    if (phase == Phase::kAlarmed) {
      record.Append(sample);
    } else {
      record.Remember(sample);
    }
    if (detector) {
      if (detector_fresh) observation.restart = true;
      detector_fresh = false;
      const std::optional<Alarm> alarm = detector->Push(observation);
      if (alarm && (!only_sharp || TakesThePlace(*alarm))) {
        OnAlarm(*alarm, sample);
        return;
      }
      if (hum && !only_sharp) {
        const auto [um_v, ia_a, w_rad_s] = detector->BoundedInnovations();
        hum->Learn(sample.t_s, um_v, ia_a);
      }
    }
    if (phase == Phase::kAlarmed && record.FitIsDue()) {
      pending = MakeIsolation();
      record.ScheduleNextFit();
    }
  }

  /// A reading that is far off by itself, while an alarm of accumulated evidence is worked out: of
  /// seconds, in which a rig may have warmed up; of less, where it is much farther off than what
  /// raised that alarm can have been.
  bool TakesThePlace(const Alarm& alarm) const {
    constexpr double kMuchFarther = 2.0;
    return alarm.sharp &&
           (alarm_detector == kOfSeconds || alarm.statistic > kMuchFarther * alarm.threshold);
  }

  void OnAlarm(const Alarm& alarm, const Sample& sample) {
    record.Open(alarm, phase == Phase::kAlarmed);
    alarm_t_s = sample.t_s;
    alarm_detector = alarm.detector;
    oldest_valid_id = next_id;
    reference = watched;
    pending.reset();
    if (only_sharp) {
      // What was being worked out was not this: a warming winding, say, a moment before a fault.
      if (!held_back && verdict.group.empty()) episodes.Withdraw();
      only_sharp = false;
    } else {
      noise_scale = detector->noise_scale();
      only_sharp = alarm_detector.starts_with("glr");
    }
    if (!only_sharp) detector.reset();
    phase = Phase::kAlarmed;
    // The next step of a rig that warms up is told only if it turns out to be something else.
    held_back = warms_up && reference.empty() && alarm_detector.starts_with("glr");
    if (held_back) return;
    Verdict next = AlarmVerdict();
    episodes.Open(next);
    Publish(std::move(next));
  }

  IsolationTask MakeIsolation() {
    IsolationTask task;
    record.Fill(task);
    task.id = next_id++;
    task.calibration = calibration;
    task.options = {options.bench,
                    options.channels,
                    options.values,
                    options.motor_faults,
                    options.period_s,
                    options.um_rail_v};
    task.reference = reference;
    task.alarm_t_s = alarm_t_s;
    task.detector = alarm_detector;
    return task;
  }

  void AcceptIsolation(IsolationResult&& result) {
    if (result.id < oldest_valid_id || phase != Phase::kAlarmed) return;
    Verdict next = std::move(result.verdict);
    if (result.onset) record.SetOnset(*result.onset);
    if (!next.onset_s) next.onset_s = record.onset_t_s();
    next.path = PaperMethodsAt(*options.bench, frame, *calibration).path;
    if (result.returned_to_nominal) {
      // Do not withdraw a small fault before the window has filled.
      if (!next.settled) return;
      if (result.gain > kWithdrawGain &&
          record.since_alarm() < SpanOf(kWithdrawAfter, options.period_s))
        return;
      ReturnToNominal(next, result.warmed ? result.shift : std::vector<double>{});
      return;
    }
    if (held_back) {
      held_back = false;
      episodes.Open(AlarmVerdict());
    }
    episodes.Update(next, result.shape, alarm_t_s);
    const bool watchable = next.settled && next.kind == VerdictKind::kFault &&
                           result.shape == FaultShape::kAbrupt && !result.present.empty();
    if (watchable) {
      StartWatching(result.present, result.shift, static_cast<int>(record.since_alarm()));
    } else if (next.settled && only_sharp) {
      detector.reset();
      only_sharp = false;
    }
    Publish(std::move(next));
  }

  /// @param shift  where a rig that has warmed up is now
  void ReturnToNominal(const Verdict& last, const std::vector<double>& shift) {
    if (!held_back) episodes.Withdraw();
    held_back = false;
    warms_up = warms_up || !shift.empty();
    impulse_seen = impulse_seen || (shift.empty() && alarm_detector == "residual");
    record.Close();
    phase = Phase::kWatching;
    StartWatching({}, shift, calibration->samples);
    Publish(NominalVerdict(last.reason));
  }

  /// Of an alarm of which nothing else is known yet.
  Verdict AlarmVerdict() const {
    Verdict next;
    next.kind = VerdictKind::kFault;
    next.detected_at_s = alarm_t_s;
    next.onset_s = record.onset_t_s();
    next.detector = alarm_detector;
    next.reason = kBeingWorkedOut;
    return next;
  }

  // ---- views
  Diagnosis View() const {
    Diagnosis diagnosis;
    diagnosis.verdict = verdict;
    if (calibration) diagnosis.calibration = *calibration;
    diagnosis.calibration_refusal = refusal;
    diagnosis.estimates = frame.estimates;
    diagnosis.nominal_estimates = NominalEstimates(options, calibration.get());
    if (calibration) diagnosis.paper = PaperMethodsAt(*options.bench, frame, *calibration);
    diagnosis.episodes = episodes.list();
    return diagnosis;
  }
};

Pipeline::Pipeline(DiagnosisOptions options)
    : state_(std::make_unique<State>(std::move(options))) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

const Frame& Pipeline::Push(const Sample& sample) {
  State& s = *state_;
  s.frame.sample = sample;
  s.bank.Push(sample, s.frame.estimates);
  using Phase = State::Phase;
  switch (s.phase) {
    case Phase::kWaiting:
    case Phase::kLearning:
      if (sample.t_s < s.options.healthy_from_s) break;
      if (sample.t_s < s.options.healthy_to_s) {
        s.phase = Phase::kLearning;
        s.learning.push_back(sample);
        break;
      }
      s.phase = Phase::kCalibrating;
      s.pending = s.MakeCalibration();
      // The detector settles on the end of the healthy stretch before its first judgement.
      s.backlog.assign(
          s.learning.end() - static_cast<std::ptrdiff_t>(std::min(
                                 s.learning.size(), SpanOf(kSettling, s.options.period_s))),
          s.learning.end());
      s.backlog.push_back(sample);
      break;
    case Phase::kCalibrating:
      if (s.backlog.size() < SpanOf(kBacklogMax, s.options.period_s)) s.backlog.push_back(sample);
      break;
    case Phase::kRefused:
      break;
    case Phase::kWatching:
    case Phase::kAlarmed:
      if (sample.t_s >= s.options.healthy_from_s) s.Watch(sample);
      break;
  }
  return s.frame;
}

const Verdict& Pipeline::verdict() const {
  return state_->verdict;
}

std::uint64_t Pipeline::verdict_version() const {
  return state_->version;
}

std::optional<DiagnosisTask> Pipeline::TakeTask() {
  std::optional<DiagnosisTask> task = std::move(state_->pending);
  state_->pending.reset();
  return task;
}

void Pipeline::Accept(DiagnosisResult result) {
  State& s = *state_;
  if (auto* isolation = std::get_if<IsolationResult>(&result)) {
    s.AcceptIsolation(std::move(*isolation));
    return;
  }
  auto& learnt = std::get<CalibrationResult>(result);
  if (s.phase != State::Phase::kCalibrating || learnt.id < s.oldest_valid_id) return;
  if (learnt.calibration != nullptr) {
    s.Calibrated(std::move(learnt.calibration));
  } else {
    s.Refuse(learnt.refusal.value_or(Error{ErrorCode::kInvalid, "calibration refused", ""}));
  }
}

void Pipeline::LearnAgain(double from_s) {
  DiagnosisOptions next = state_->options;
  next.healthy_to_s = from_s + next.healthy_to_s - next.healthy_from_s;
  next.healthy_from_s = from_s;
  next.calibration.reset();
  // Everything but the estimates begins again; results of older tasks are not taken.
  auto fresh = std::make_unique<State>(std::move(next));
  fresh->bank = std::move(state_->bank);
  fresh->frame = state_->frame;
  fresh->version = state_->version + 1;
  fresh->next_id = state_->next_id;
  fresh->oldest_valid_id = state_->next_id;
  state_ = std::move(fresh);
}

Learning Pipeline::learning() const {
  switch (state_->phase) {
    case State::Phase::kWaiting:
    case State::Phase::kLearning:
      return Learning::kStretch;
    case State::Phase::kCalibrating:
      return Learning::kSolving;
    case State::Phase::kRefused:
      return Learning::kGivenUp;
    case State::Phase::kWatching:
    case State::Phase::kAlarmed:
      break;
  }
  return Learning::kLearnt;
}

std::shared_ptr<const Calibration> Pipeline::calibration() const {
  return state_->calibration;
}

Diagnosis Pipeline::Snapshot() const {
  return state_->View();
}

Diagnosis Pipeline::Finish() {
  State& s = *state_;
  if (s.phase == State::Phase::kWaiting || s.phase == State::Phase::kLearning) {
    // The run ended inside the healthy stretch; the samples so far may be enough for a calibration.
    s.phase = State::Phase::kCalibrating;
    s.pending = s.MakeCalibration();
  }
  while (std::optional<DiagnosisTask> task = TakeTask()) Accept(RunTask(*task));
  if (s.phase == State::Phase::kAlarmed && s.record.since_alarm() > 0) {
    IsolationTask last = s.MakeIsolation();
    last.settled = true;
    Accept(Isolate(last));
  }
  if (s.verdict.reason == kBeingWorkedOut) {
    Verdict last = s.verdict;
    last.kind = VerdictKind::kUnknownFault;
    last.reason = "something has changed just before the end: too little follows to say what";
    s.episodes.Update(last, FaultShape::kAbrupt, s.alarm_t_s);
    s.Publish(std::move(last));
  }
  return s.View();
}

}  // namespace faultlab::core
