#include "core/diagnosis/rig_watch.h"

#include <cstdlib>
#include <utility>

#include "core/diagnosis/paper_view.h"
#include "core/filter/rig_parameters.h"
#include "core/filter/speed_response.h"
#include "core/isolation/fit_context.h"

namespace faultlab::core {
namespace {

// An alarm is withdrawn when no fault explains it. If a fault explains it a little, it may be a
// small fault, and more data is needed first.
constexpr double kWithdrawGain = 8.0;
constexpr std::size_t kWithdrawAfter = 500;
// Of what is told early: what creeps has less when it is seen, and looks like another part that has
// changed at once.
constexpr double kLargeGain = 1000.0;
constexpr std::size_t kImpulseAfter = 50;
// A part that so many alarms in a row have found farther in the same direction moves.
constexpr int kStepsOfADrift = 2;
// The detector of small changes, which have been going on for a while when it raises an alarm.
constexpr const char* kOfSeconds = "glr_500";
constexpr const char* kTooLate =
    "something has changed just before the end: too little follows to say what";
constexpr const char* kEndsTooSoon =
    "something may have changed a little: the record ends too soon after the alarm to tell";
constexpr const char* kBeingWorkedOut = "something has changed; what, is being worked out";

// The calibrated rig, its coordinates moved by `shift` (all of them, or none).
RigParameters MovedRig(const Calibration& calibration,
                       const std::vector<double>& shift,
                       double period_s) {
  const RigParameters rig = ParametersOf(calibration);
  if (shift.empty()) return rig;
  const auto n = static_cast<Eigen::Index>(shift.size());
  return Moved(rig, Eigen::Map<const Eigen::VectorXd>(shift.data(), n), period_s);
}

Verdict NominalVerdict(std::string reason) {
  Verdict verdict;
  verdict.kind = VerdictKind::kNominal;
  verdict.settled = true;
  verdict.reason = std::move(reason);
  return verdict;
}

}  // namespace

RigWatch::RigWatch(const DiagnosisOptions& options,
                   std::shared_ptr<const Calibration> calibration,
                   std::uint64_t next_id)
    : options_(options),
      calibration_(std::move(calibration)),
      builder_(options.bench->readings(),
               options.channels,
               options.period_s,
               options.um_rail_v,
               ErrorsOf(*calibration_)),
      record_(options.period_s),
      noise_scale_(calibration_->samples),
      next_id_(next_id),
      oldest_valid_id_(next_id) {
  if (calibration_->hum.any())
    hum_.emplace(calibration_->hum, NoiseOf(*calibration_), options.period_s);
  Watch({}, calibration_->samples);
  Verdict verdict = NominalVerdict("the record fits the calibrated rig");
  // Who brings voltage and speed alone asks for the response.
  if (options.bench->structure->estimated == EstimatedChannel::kSpeed) {
    const SpeedResponse response = SpeedResponseOf(*calibration_);
    verdict.response = ResponseChange{response, response};
  }
  Publish(std::move(verdict));
}

void RigWatch::Publish(Verdict next) {
  verdict_ = std::move(next);
  ++version_;
}

std::optional<IsolationTask> RigWatch::TakeTask() {
  return std::exchange(pending_, std::nullopt);
}

void RigWatch::Watch(KnownRig rig, int samples) {
  RigParameters reference = MovedRig(*calibration_, rig.shift, options_.period_s);
  reference.direct_factor = rig.direct_factor;
  for (const Candidate& fault : rig.faults) {
    reference = WithComponent(reference, fault.component, fault.value);
  }
  NoiseLevel noise = DetectionNoiseOf(*calibration_);
  for (double NoiseLevel::*of : {&NoiseLevel::um_v, &NoiseLevel::ia_a, &NoiseLevel::w_rad_s}) {
    noise.*of *= rig.noise_factor;
  }
  detector_.emplace(*options_.bench,
                    reference,
                    noise,
                    options_.period_s,
                    calibration_->mask(),
                    calibration_->thresholds,
                    samples,
                    noise_scale_,
                    rig.faults.empty() ? 0.0 : options_.bench->n.step_s,
                    KnowsImpulses(),
                    calibration_->model_error);
  detector_fresh_ = true;
  if (alarm_) alarm_->only_sharp = false;
  watched_ = std::move(rig);
}

void RigWatch::Push(const Sample& as_read) {
  const Sample sample = hum_ ? hum_->Clean(as_read) : as_read;
  Observation observation;
  if (!builder_.Push(sample, observation)) return;
  if (alarm_) {
    record_.Append(sample);
  } else {
    record_.Remember(sample);
  }
  if (detector_) {
    if (detector_fresh_) observation.restart = true;
    detector_fresh_ = false;
    const std::optional<Alarm> alarm = detector_->Push(observation);
    const bool only_sharp = alarm_ && alarm_->only_sharp;
    if (alarm && (!only_sharp || TakesThePlace(*alarm))) {
      OnAlarm(*alarm, sample);
      return;
    }
    if (hum_ && !only_sharp) {
      const auto [um_v, ia_a, w_rad_s] = detector_->BoundedInnovations();
      hum_->Learn(sample.t_s, um_v, ia_a);
    }
  }
  if (alarm_ && record_.FitIsDue()) {
    pending_ = MakeTask();
    record_.ScheduleNextFit();
  }
}

/// A reading that is far off by itself, while an alarm of accumulated evidence is worked out: of
/// seconds, in which a rig may have warmed up; of less, where it is much farther off than what
/// raised that alarm can have been.
bool RigWatch::TakesThePlace(const Alarm& alarm) const {
  constexpr double kMuchFarther = 2.0;
  return alarm.sharp &&
         (alarm_->detector == kOfSeconds || alarm.statistic > kMuchFarther * alarm.threshold);
}

void RigWatch::OnAlarm(const Alarm& alarm, const Sample& sample) {
  record_.Open(alarm, alarm_.has_value());
  pending_.reset();
  oldest_valid_id_ = next_id_;
  OpenAlarm next{watched_, sample.t_s, alarm.detector};
  const bool healthy = watched_.faults.empty();
  const bool small = SeesSmallChanges(alarm.detector);
  next.one_reading = next.detector == "residual" && healthy && !KnowsImpulses();
  // The next step of a rig that warms up, or of a fault that moves, is told only if it turns out to
  // be something else; so is the next small change after one that has come to nothing.
  next.held_back = watched_.has_moved || (doubts_small_ && small);
  if (alarm_ && alarm_->only_sharp) {
    // What was being worked out was not this: a warming winding, say, a moment before a fault.
    if (!alarm_->held_back && verdict_.group.empty()) {
      if (healthy) {
        episodes_.Withdraw();
      } else {
        episodes_.Resume();
      }
    }
  } else {
    if (watched_.noise_factor == 1.0) noise_scale_ = detector_->noise_scale();
    next.only_sharp = small;
  }
  if (!next.only_sharp) detector_.reset();
  alarm_ = std::move(next);
  if (alarm_->held_back) return;
  Verdict verdict = AlarmVerdict();
  episodes_.Open(verdict);
  Publish(std::move(verdict));
}

IsolationTask RigWatch::MakeTask() {
  IsolationTask task;
  record_.Fill(task);
  task.id = next_id_++;
  task.calibration = calibration_;
  task.options = {options_.bench,
                  options_.channels,
                  options_.values,
                  options_.motor_faults,
                  options_.period_s,
                  options_.um_rail_v};
  task.reference = alarm_->before.faults;
  task.alike = alarm_->before.alike;
  task.found = alarm_->found;
  task.has_moved = alarm_->before.has_moved;
  task.found_turning = alarm_->found_turning;
  task.alike_at_rest = alarm_->alike_at_rest;
  task.alarm_t_s = alarm_->t_s;
  task.detector = alarm_->detector;
  return task;
}

void RigWatch::Accept(IsolationResult&& result, const Frame& frame) {
  if (result.id < oldest_valid_id_ || !alarm_) return;
  if (result.early) {
    TellEarly(std::move(result), frame);
    return;
  }
  Verdict next = std::move(result.verdict);
  if (result.onset) record_.SetOnset(*result.onset);
  if (!next.onset_s) next.onset_s = record_.onset_t_s();
  next.path = PaperMethodsAt(*options_.bench, frame, *calibration_).path;
  if (next.settled && result.impulse) impulse_seen_ = true;
  if (result.shows_neither) return;
  if (result.returned_to_nominal && !MayBeWithdrawn(next.settled, result.gain)) return;
  if (alarm_->held_back) {
    if (result.moved_on && !next.settled) return;
    const bool nothing = result.returned_to_nominal && alarm_->before.faults.empty();
    alarm_->held_back = result.moved_on || nothing;
    if (!alarm_->held_back) episodes_.Open(AlarmVerdict());
  }
  if (result.returned_to_nominal) {
    ReturnToNominal(next, result.warmed ? result.shift : std::vector<double>{});
    return;
  }
  if (next.kind != VerdictKind::kFault || result.shape == FaultShape::kDrift) {
    record_.FitFromAlarm();
  }
  Remember(result, next);
  alarm_->held_back ? episodes_.GoOn(next) : episodes_.Update(next, result.shape, alarm_->t_s);
  if (next.settled) WatchOn(result, next);
  Publish(std::move(next));
}

/// What is sure after a few samples. Nothing is learnt from it: the next answers see more.
void RigWatch::TellEarly(IsolationResult&& result, const Frame& frame) {
  Verdict& next = result.verdict;
  const bool first = alarm_->before.faults.empty() && !alarm_->held_back;
  const bool large = result.gain > kLargeGain && result.shape == FaultShape::kAbrupt;
  if (!first || !large || !result.sure || next.kind != VerdictKind::kFault) return;
  if (!next.onset_s) next.onset_s = record_.onset_t_s();
  next.path = PaperMethodsAt(*options_.bench, frame, *calibration_).path;
  episodes_.Update(next, result.shape, alarm_->t_s);
  Publish(std::move(next));
}

/// What the answer has found, for the next ones, which may see less.
void RigWatch::Remember(const IsolationResult& result, const Verdict& next) {
  if (alarm_->found_turning.empty() ? result.adequate : result.moves) {
    alarm_->found_turning = next.group;
    alarm_->found_moving = result.moves;
  }
  // The beginning of a drift may look like another part that has failed at once.
  if (next.kind == VerdictKind::kUnknownFault && !alarm_->found_moving) {
    alarm_->found_turning.clear();
  }
  if (result.noise_factor > 1.0) alarm_->alike_at_rest = next.group;
}

/// With what is known now; nothing is watched where what has changed is unknown or moves.
void RigWatch::WatchOn(const IsolationResult& result, const Verdict& next) {
  alarm_->found.clear();
  if (next.kind != VerdictKind::kFault || result.moves || result.present.empty()) {
    if (alarm_->only_sharp) detector_.reset();
    alarm_->only_sharp = false;
    record_.FitSoon();
    return;
  }
  alarm_->found = result.present;
  const int steps = StepsTo(result.present);
  const bool has_moved = result.shape == FaultShape::kDrift || std::abs(steps) >= kStepsOfADrift;
  Watch({result.shift,
         result.direct_factor,
         result.present,
         next.group,
         steps,
         has_moved,
         result.noise_factor},
        static_cast<int>(result.samples));
}

int RigWatch::StepsTo(const std::vector<Candidate>& present) const {
  const KnownRig& before = alarm_->before;
  const std::vector<Candidate>& known = before.faults;
  if (present.size() != known.size() || present.back().component != known.back().component) {
    return 0;
  }
  const int step = present.back().value > known.back().value ? 1 : -1;
  return before.steps * step > 0 ? before.steps + step : step;
}

/// A small fault is not withdrawn before the window has filled. One reading that was far off is no
/// small fault: what hides behind it is found again by what it accumulates; so is what a known
/// fault leaves that is gone.
/// @param gain  of the best fault over the nominal rig, which explains the record
bool RigWatch::MayBeWithdrawn(bool settled, double gain) const {
  const auto passed = [&](std::size_t samples) {
    return record_.since_alarm() >= SpanOf(samples, options_.period_s);
  };
  if (!alarm_->before.faults.empty()) return settled;
  const bool hardly = gain <= kWithdrawGain;
  if (alarm_->one_reading) return settled || (hardly && passed(kImpulseAfter));
  return settled && (hardly || passed(kWithdrawAfter));
}

bool RigWatch::KnowsImpulses() const {
  return calibration_->impulse_share > 0.0 || impulse_seen_;
}

/// @param shift  where a rig that has warmed up is now
void RigWatch::ReturnToNominal(const Verdict& last, const std::vector<double>& shift) {
  if (!alarm_->held_back) episodes_.Withdraw();
  const bool nothing = alarm_->before.faults.empty() && SeesSmallChanges(alarm_->detector);
  doubts_small_ = doubts_small_ || !shift.empty() || nothing;
  impulse_seen_ = impulse_seen_ || (shift.empty() && alarm_->one_reading);
  record_.Close();
  alarm_.reset();
  KnownRig healthy;
  healthy.shift = shift;
  Watch(std::move(healthy), calibration_->samples);
  Publish(NominalVerdict(last.reason));
}

/// Of an alarm of which nothing else is known yet.
Verdict RigWatch::AlarmVerdict() const {
  Verdict next;
  next.kind = VerdictKind::kFault;
  next.detected_at_s = alarm_->t_s;
  next.onset_s = record_.onset_t_s();
  next.detector = alarm_->detector;
  next.reason = kBeingWorkedOut;
  return next;
}

void RigWatch::Finish(const Frame& frame) {
  if (alarm_ && !alarm_->before.faults.empty() && !record_.HasBeenFitted()) {
    // A known fault stays known.
    if (alarm_->held_back) return;
    Verdict known = episodes_.Resume();
    known.reason += std::string("; ") + kTooLate;
    Publish(std::move(known));
    return;
  }
  if (alarm_ && record_.since_alarm() > 0) {
    IsolationTask last = MakeTask();
    last.settled = true;
    last.early = false;
    Accept(Isolate(last), frame);
  }
  if (verdict_.reason != kBeingWorkedOut) return;
  Verdict last = verdict_;
  last.kind = VerdictKind::kUnknownFault;
  last.reason = record_.HasBeenFitted() ? kEndsTooSoon : kTooLate;
  episodes_.Update(last, FaultShape::kAbrupt, alarm_->t_s);
  Publish(std::move(last));
}

}  // namespace faultlab::core
