#include "core/diagnosis/pipeline.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/paper_view.h"
#include "core/diagnosis/rig_watch.h"
#include "core/estimators/estimator_bank.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {
namespace {

// Samples kept until the calibration is finished; more than any machine needs for a fit.
constexpr std::size_t kBacklogMax = 3000;
// Samples at the end of the healthy stretch during which the detector settles.
constexpr std::size_t kSettling = 50;

}  // namespace

struct Pipeline::State {
  enum class Phase { kWaiting, kLearning, kCalibrating, kRefused, kWatching };

  explicit State(DiagnosisOptions o) : options(std::move(o)), bank(BankOptions(options)) {
    if (!options.calibration) return;
    calibration = std::make_shared<const Calibration>(WithHumAsNoise(*options.calibration));
    Watch();
  }

  DiagnosisOptions options;
  EstimatorBank bank;
  Phase phase = Phase::kWaiting;
  Frame frame;
  std::shared_ptr<const Calibration> calibration;
  std::optional<Error> refusal;
  Verdict unwatched;  // of a rig that is not watched
  std::uint64_t version = 1;

  std::vector<Sample> learning;
  std::vector<Sample> backlog;  // since the end of the healthy stretch, until calibrated
  std::optional<CalibrationTask> pending;
  std::uint64_t next_id = 1;
  std::uint64_t oldest_valid_id = 1;
  std::optional<RigWatch> watch;  // once it is calibrated

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
    const bool poor = error.field == "excitation";
    unwatched.kind = poor ? VerdictKind::kNotExcited : VerdictKind::kCalibrating;
    unwatched.settled = true;
    unwatched.reason = error.message;
    ++version;
  }

  void Watch() {
    phase = Phase::kWatching;
    watch.emplace(options, calibration, next_id);
  }

  void Calibrated(std::shared_ptr<const Calibration> learnt) {
    calibration = std::move(learnt);
    Watch();
    // The detector starts on the end of the healthy stretch and judges only what follows.
    for (const Sample& sample : backlog) watch->Push(sample);
    backlog.clear();
  }

  // ---- views
  Diagnosis View() const {
    Diagnosis diagnosis;
    diagnosis.verdict = watch ? watch->verdict() : unwatched;
    if (calibration) diagnosis.calibration = *calibration;
    diagnosis.calibration_refusal = refusal;
    diagnosis.estimates = frame.estimates;
    diagnosis.nominal_estimates = NominalEstimates(options, calibration.get());
    if (calibration) diagnosis.paper = PaperMethodsAt(*options.bench, frame, *calibration);
    if (watch) diagnosis.episodes = watch->episodes();
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
      if (sample.t_s >= s.options.healthy_from_s) s.watch->Push(sample);
      break;
  }
  return s.frame;
}

const Verdict& Pipeline::verdict() const {
  return state_->watch ? state_->watch->verdict() : state_->unwatched;
}

std::uint64_t Pipeline::verdict_version() const {
  return state_->version + (state_->watch ? state_->watch->verdict_version() : 0);
}

std::optional<DiagnosisTask> Pipeline::TakeTask() {
  State& s = *state_;
  if (s.pending) return std::exchange(s.pending, std::nullopt);
  return s.watch ? std::optional<DiagnosisTask>(s.watch->TakeTask()) : std::nullopt;
}

void Pipeline::Accept(DiagnosisResult result) {
  State& s = *state_;
  if (auto* isolation = std::get_if<IsolationResult>(&result)) {
    if (s.watch) s.watch->Accept(std::move(*isolation), s.frame);
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
  fresh->version = verdict_version() + 1;
  fresh->next_id = state_->watch ? state_->watch->next_id() : state_->next_id;
  fresh->oldest_valid_id = fresh->next_id;
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
  if (s.watch) s.watch->Finish(s.frame);
  return s.View();
}

}  // namespace faultlab::core
