#include "core/diagnosis/pipeline.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/detection/detector.h"
#include "core/diagnosis/diagnosis.h"
#include "core/estimators/estimator_bank.h"
#include "core/filter/observation.h"
#include "core/isolation/verdict_text.h"
#include "core/plant/coefficients.h"

namespace faultlab::core {
namespace {

// Samples after the alarm at which the hypotheses are fitted; later ones every kSolveEvery.
constexpr std::array<std::size_t, 6> kSolveAt = {25, 50, 100, 200, 500, 1000};
constexpr std::size_t kSolveEvery = 500;
// From here on a fit is taken for settled: the paper's SWA window.
constexpr std::size_t kSettledAfter = 100;
// History kept before an alarm, and data kept after it.
constexpr std::size_t kHistory = 600;
constexpr std::size_t kHistoryBlock = 100;  // dropped at once
// An alarm that no fault explains is withdrawn; one that a fault explains a little may be a small
// fault, which needs more data.
constexpr double kWithdrawGain = 8.0;
constexpr std::size_t kWithdrawAfter = 500;
constexpr std::size_t kSegmentMax = 2000;
// Samples that wait for the calibration to come back; more than a fit can take on any machine.
constexpr std::size_t kBacklogMax = 3000;
// The estimate that the paper's methods are shown with.
constexpr std::size_t kEstimatorForPath = static_cast<std::size_t>(EstimatorId::kSia100x20);

}  // namespace

struct Pipeline::State {
  enum class Phase { kWaiting, kLearning, kCalibrating, kRefused, kWatching, kAlarmed };

  explicit State(DiagnosisOptions o)
      : options(std::move(o)),
        bank(BankOptions(options)),
        builder(options.channels, options.period_s, options.um_rail_v) {
    history.reserve(kHistory + kHistoryBlock);
    if (options.calibration) {
      calibration = std::make_shared<const Calibration>(*options.calibration);
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
  std::vector<Sample> history;  // newest samples while watching
  std::vector<Sample> segment;  // history and everything since the alarm
  std::size_t alarm_at = 0;     // in `segment`
  std::size_t fit_from = 0;
  std::size_t since_alarm = 0;
  std::size_t next_solve = 0;
  std::optional<Detector> detector;
  std::optional<NoiseScale> noise_scale;  // outlives the detectors that learn it
  bool detector_fresh = false;
  std::optional<IsolationTask> pending;
  std::uint64_t next_id = 1;
  std::uint64_t oldest_valid_id = 1;
  std::vector<Candidate> reference;  // faults carried by the model before the present alarm
  std::vector<Candidate> watched;    // faults carried by the detector's model
  double alarm_t_s = 0.0;
  double onset_t_s = 0.0;      // by the detector
  std::optional<Onset> onset;  // by the fits, while the segment reached back to it
  bool onset_gone = false;     // from the segment
  std::string alarm_detector;
  std::vector<FaultEpisode> episodes;
  bool episode_open = false;
  bool alarm_merged = false;  // the present alarm was the last episode's going on

  // ---- verdicts
  void Publish(Verdict next) {
    verdict = std::move(next);
    ++version;
  }

  void SetNominal() {
    Verdict next;
    next.kind = VerdictKind::kNominal;
    next.settled = true;
    next.reason = "the record fits the calibrated rig";
    Publish(std::move(next));
  }

  // ---- calibration
  IsolationTask CalibrationTask() {
    IsolationTask task;
    task.kind = IsolationTask::Kind::kCalibrate;
    task.id = next_id++;
    task.samples = learning;
    task.calibration_options.data_sheet = options.nominal;
    task.calibration_options.channels = options.channels;
    task.calibration_options.period_s = options.period_s;
    task.calibration_options.false_alarms_per_day = options.false_alarms_per_day;
    task.calibration_options.um_rail_v = options.um_rail_v;
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
    // The healthy stretch itself warms the detector up and is judged by it no more.
    const std::vector<Sample> missed = std::move(backlog);
    backlog.clear();
    builder = ObservationBuilder(options.channels, options.period_s, options.um_rail_v);
    for (const Sample& sample : missed) Watch(sample);
  }

  // ---- watching
  unsigned Mask() const {
    return 1U | (calibration->used_ia ? 2U : 0U) | (calibration->used_n ? 4U : 0U);
  }

  RigParameters ReferenceRig(const std::vector<Candidate>& faults,
                             const std::vector<double>& shift) const {
    RigParameters rig = ParametersOf(*calibration);
    if (shift.size() == static_cast<std::size_t>(kCoordinateCount)) {
      Coordinates coordinates;
      std::copy(shift.begin(), shift.end(), coordinates.begin());
      rig = Moved(rig, coordinates, options.period_s);
    }
    for (const Candidate& fault : faults) rig.plant.Set(fault.component, fault.value);
    return rig;
  }

  void StartWatching(const std::vector<Candidate>& faults,
                     const std::vector<double>& shift,
                     int samples) {
    if (!noise_scale) noise_scale.emplace(calibration->samples);
    detector.emplace(ReferenceRig(faults, shift),
                     DetectionNoiseOf(*calibration),
                     options.period_s,
                     Mask(),
                     calibration->thresholds,
                     samples,
                     *noise_scale);
    detector_fresh = true;
    watched = faults;
  }

  void Watch(const Sample& sample) {
    Observation observation;
    if (!builder.Push(sample, observation)) return;
    if (phase == Phase::kAlarmed) {
      segment.push_back(sample);
      ++since_alarm;
    } else {
      if (history.size() == kHistory + kHistoryBlock) {
        history.erase(history.begin(), history.begin() + kHistoryBlock);
      }
      history.push_back(sample);
    }
    if (detector) {
      if (detector_fresh) observation.restart = true;
      detector_fresh = false;
      if (const std::optional<Alarm> alarm = detector->Push(observation)) {
        OnAlarm(*alarm, sample);
        return;
      }
    }
    if (phase == Phase::kAlarmed && since_alarm >= next_solve) {
      EmitIsolation();
      const auto later = std::find_if(
          kSolveAt.begin(), kSolveAt.end(), [&](std::size_t at) { return at > since_alarm; });
      next_solve = later != kSolveAt.end() ? *later : since_alarm + kSolveEvery;
    }
  }

  void OnAlarm(const Alarm& alarm, const Sample& sample) {
    std::vector<Sample>& past = phase == Phase::kAlarmed ? segment : history;
    const std::size_t keep = std::min(past.size(), kHistory);
    std::vector<Sample> recent(past.end() - static_cast<std::ptrdiff_t>(keep), past.end());
    segment = std::move(recent);
    segment.reserve(kSegmentMax + kHistory);
    history.clear();
    alarm_at = segment.size() - 1;
    const auto ago = std::min(alarm_at, static_cast<std::size_t>(std::max(0, alarm.samples_ago)));
    fit_from = alarm.sharp ? alarm_at : alarm_at - ago;
    onset_t_s = segment[alarm_at - ago].t_s;
    onset.reset();
    onset_gone = false;
    since_alarm = 0;
    next_solve = kSolveAt.front();
    alarm_t_s = sample.t_s;
    alarm_detector = alarm.detector;
    oldest_valid_id = next_id;
    reference = watched;
    pending.reset();
    noise_scale = detector->noise_scale();
    detector.reset();
    alarm_merged = false;
    if (episode_open) CloseEpisode(sample.t_s);
    phase = Phase::kAlarmed;
    Verdict next;
    next.kind = VerdictKind::kFault;
    next.detected_at_s = alarm_t_s;
    next.onset_s = onset_t_s;
    next.detector = alarm_detector;
    next.reason = "something has changed; what, is being worked out";
    episodes.push_back({next, FaultShape::kAbrupt, std::nullopt});
    episode_open = true;
    Publish(std::move(next));
  }

  void CloseEpisode(double t_s) {
    if (!episodes.empty()) episodes.back().ended_at_s = t_s;
    episode_open = false;
  }

  void EmitIsolation() { pending = MakeIsolation(); }

  IsolationTask MakeIsolation() {
    if (segment.size() > kSegmentMax + kHistory) {
      const std::size_t drop = segment.size() - kSegmentMax;
      segment.erase(segment.begin(), segment.begin() + static_cast<std::ptrdiff_t>(drop));
      onset_gone = true;
      alarm_at -= std::min(alarm_at, drop);
      fit_from -= std::min(fit_from, drop);
    }
    IsolationTask task;
    task.kind = IsolationTask::Kind::kIsolate;
    task.id = next_id++;
    task.samples = segment;
    task.alarm_at = alarm_at;
    task.fit_from = fit_from;
    task.calibration = calibration;
    task.options = {options.channels,
                    options.values,
                    options.motor_faults,
                    options.period_s,
                    options.um_rail_v};
    task.reference = reference;
    task.alarm_t_s = alarm_t_s;
    if (onset_gone) task.onset = onset.value_or(Onset{onset_t_s, false});
    task.detector = alarm_detector;
    task.settled = since_alarm >= kSettledAfter;
    return task;
  }

  void AcceptIsolation(IsolationResult&& result) {
    if (result.id < oldest_valid_id || phase != Phase::kAlarmed) return;
    Verdict next = std::move(result.verdict);
    if (result.onset) onset = result.onset;
    if (!next.onset_s) next.onset_s = onset_t_s;
    next.path = Paper().path;
    if (result.returned_to_nominal) {
      // A small fault needs more than a glimpse.
      if (!next.settled) return;
      if (result.gain > kWithdrawGain && since_alarm < kWithdrawAfter) return;
      ReturnToNominal(next);
      return;
    }
    if (ContinuesLastEpisode(next)) {
      // The same component again: it moves on, or the first fit was not the last word.
      const Verdict& first = episodes[episodes.size() - 2].verdict;
      next.detected_at_s = first.detected_at_s;
      next.onset_s = first.onset_s;
      next.detector = first.detector;
      episodes.pop_back();
      episodes.back().ended_at_s.reset();
      alarm_merged = true;
    }
    if (alarm_merged) {
      next.detected_at_s = episodes.back().verdict.detected_at_s;
      next.onset_s = episodes.back().verdict.onset_s;
      next.detector = episodes.back().verdict.detector;
    }
    episodes.back().verdict = next;
    episodes.back().shape = result.shape;
    const bool watchable = next.settled && next.kind == VerdictKind::kFault &&
                           result.shape == FaultShape::kAbrupt && !result.present.empty();
    if (watchable) {
      StartWatching(result.present, result.shift, static_cast<int>(since_alarm));
    }
    Publish(std::move(next));
  }

  bool ContinuesLastEpisode(const Verdict& next) const {
    if (alarm_merged || episodes.size() < 2 || next.kind != VerdictKind::kFault) return false;
    const FaultEpisode& last = episodes[episodes.size() - 2];
    if (!last.ended_at_s || *last.ended_at_s != alarm_t_s) return false;
    const std::vector<Component>& then = last.verdict.group;
    return std::any_of(next.group.begin(), next.group.end(), [&](Component component) {
      return std::find(then.begin(), then.end(), component) != then.end();
    });
  }

  void ReturnToNominal(const Verdict& last) {
    // An alarm that nothing came of is no episode.
    episodes.pop_back();
    episode_open = false;
    history.assign(segment.end() - static_cast<std::ptrdiff_t>(std::min(segment.size(), kHistory)),
                   segment.end());
    segment.clear();
    phase = Phase::kWatching;
    StartWatching({}, {}, calibration->samples);
    Verdict next;
    next.kind = VerdictKind::kNominal;
    next.settled = true;
    next.reason = last.reason;
    Publish(std::move(next));
  }

  // ---- views
  PaperMethods Paper() const {
    PaperMethods none;
    if (!calibration) return none;
    const Estimate<3>& sia = frame.estimates[kEstimatorForPath];
    if (sia.status == EstimateStatus::kInvalid) return none;
    const ContinuousTheta nominal = FirstOrderTheta(calibration->nominal, calibration->gain_factor);
    // Four standard errors, and never less than what the reduction to first order costs (1 %).
    ContinuousTheta band{};
    for (std::size_t i = 0; i < band.size(); ++i) {
      const double sigma = std::isfinite(sia.sigma[i]) ? sia.sigma[i] : 0.0;
      band[i] = std::max(4.0 * sigma, 0.02 * std::abs(nominal[i]));
    }
    return RunPaperMethods(
        calibration->nominal, nominal, {sia.theta[0], sia.theta[1], sia.theta[2]}, band);
  }

  Diagnosis View() const {
    Diagnosis diagnosis;
    diagnosis.verdict = verdict;
    if (calibration) diagnosis.calibration = *calibration;
    diagnosis.calibration_refusal = refusal;
    diagnosis.estimates = frame.estimates;
    const PlantParameters plant = calibration ? calibration->nominal : options.nominal;
    const double gain_factor = calibration ? calibration->gain_factor : 1.0;
    const double delta_s = calibration ? calibration->delta_s : 0.0;
    const ContinuousTheta theta = FirstOrderTheta(plant, gain_factor);
    ContinuousCoefficients coefficients = MakeContinuous(plant);
    coefficients.b0 = theta[0];
    coefficients.b1 = theta[1];
    const DiscreteCoefficients discrete = Discretise(coefficients, options.period_s, delta_s);
    for (std::size_t e = 0; e < kEstimatorCount; ++e) {
      diagnosis.nominal_estimates[e] =
          kEstimatorShapes[e].integral_samples > 0
              ? theta
              : ContinuousTheta{discrete.b0d, discrete.b1d, discrete.a1d};
    }
    diagnosis.paper = Paper();
    diagnosis.episodes = episodes;
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
      s.pending = s.CalibrationTask();
      // The tail of the healthy stretch lets the detector settle before its first judgement.
      s.backlog.assign(s.learning.end() - static_cast<std::ptrdiff_t>(
                                              std::min(s.learning.size(), std::size_t{50})),
                       s.learning.end());
      s.backlog.push_back(sample);
      break;
    case Phase::kCalibrating:
      if (s.backlog.size() < kBacklogMax) s.backlog.push_back(sample);
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

std::optional<IsolationTask> Pipeline::TakeTask() {
  std::optional<IsolationTask> task = std::move(state_->pending);
  state_->pending.reset();
  return task;
}

void Pipeline::Accept(IsolationResult result) {
  State& s = *state_;
  if (result.kind == IsolationTask::Kind::kCalibrate) {
    if (s.phase != State::Phase::kCalibrating) return;
    if (result.calibration != nullptr) {
      s.Calibrated(std::move(result.calibration));
    } else {
      s.Refuse(result.refusal.value_or(Error{ErrorCode::kInvalid, "calibration refused", ""}));
    }
    return;
  }
  s.AcceptIsolation(std::move(result));
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
    // The run ended inside the healthy stretch: what there is may still calibrate.
    s.phase = State::Phase::kCalibrating;
    s.pending = s.CalibrationTask();
  }
  while (std::optional<IsolationTask> task = TakeTask()) Accept(Solve(*task));
  if (s.phase == State::Phase::kAlarmed && s.since_alarm > 0) {
    IsolationTask last = s.MakeIsolation();
    last.settled = true;
    Accept(Solve(last));
  }
  return s.View();
}

}  // namespace faultlab::core
