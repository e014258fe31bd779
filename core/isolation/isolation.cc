#include "core/isolation/isolation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/filter/speed_response.h"
#include "core/isolation/clean_readings.h"
#include "core/isolation/explanation.h"
#include "core/isolation/friction_hold.h"
#include "core/isolation/lack_of_fit.h"
#include "core/isolation/nominal_context.h"
#include "core/isolation/onset.h"
#include "core/isolation/speed_rounding.h"
#include "core/isolation/verdict_text.h"
#include "core/isolation/warming.h"
#include "core/types/check.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Counts of samples are for 100 Hz; faster records use more samples for the same time (SpanOf).

// Squared distance of whitened predictions per sample, below which an hour of data would not
// distinguish two hypotheses (3.6e5 samples x 2e-5 = 7).
constexpr double kSamePrediction = 2e-5;
// Penalty for the extra parameter of a fault on top of another one.
constexpr double kSecondFaultCost = 20.0;
// Less than this share is the error of the first one's value, of the calibration or of the model.
constexpr double kSecondFaultShare = 0.03;
// Gain of a fault that the detector of small changes has just noticed.
constexpr double kHardlyVisible = 100.0;
// Four standard deviations.
constexpr double kStrained = 16.0;
// History that is searched for the onset.
constexpr std::size_t kOnsetHistory = 120;
constexpr std::size_t kAllAlong = 10;
// Residuals of twice the noise may be noise that has grown, as that of hum which beats with the
// rate.
constexpr double kNominalScoreMax = 4.0;

Candidate ToCandidate(const HypothesisFit& fit, double best_score) {
  Candidate candidate;
  candidate.component = fit.component;
  candidate.value = fit.value;
  candidate.bound = fit.bound;
  candidate.sigma =
      fit.bound != 0 ? std::numeric_limits<double>::quiet_NaN() : fit.value * fit.log_sigma;
  candidate.score = fit.chi2 / std::max(1, fit.count);
  candidate.margin = candidate.score - best_score;
  return candidate;
}

std::vector<Component> Changeable(const IsolationOptions& options) {
  std::vector<Component> components;
  for (Component component : options.bench->components()) {
    if (IsSwitched(component) || options.motor_faults) components.push_back(component);
  }
  return components;
}

class Isolation {
 public:
  explicit Isolation(const IsolationTask& task)
      : task_(task),
        changeable_(Changeable(task.options)),
        readings_(task, changeable_),
        nominal_(NominalContext(task)) {
    nominal_.stretch = readings_.stretch();
    readings_.LeaveOutKnown(nominal_);
    // The record before the alarm is healthy too, and longer than the calibration's stretch at
    // times.
    if (!readings_.history().empty()) UpdatePosterior(readings_.history(), nominal_);
    AllowForRounding();
  }

  IsolationResult Run() {
    IsolationResult result = Concluded();
    result.impulse = AlarmLeftOut();
    return result;
  }

 private:
  IsolationResult Concluded() {
    if (nominal_.stretch.size() < 2) {
      IsolationResult result = Empty();
      result.returned_to_nominal = true;
      result.verdict.kind = VerdictKind::kNominal;
      result.verdict.settled = false;
      result.verdict.reason = "too few samples after the alarm";
      return result;
    }
    Conclusion cold = Conclude(nominal_);
    if (cold.result.verdict.kind == VerdictKind::kUnknownFault && !cold.result.verdict.sensor) {
      cold = WithoutOddReadings(std::move(cold));
      if (!cold.explanation.lack_of_fit.adequate) cold = Steep(std::move(cold));
    }
    IsolationResult& result = cold.result;
    const bool maybe_healthy = MayBeWarming(result);
    const bool heals = NamesAnotherInstead(result);
    if (!maybe_healthy && !heals && !IsStrained(cold)) return result;
    Conclusion warmed = Conclude(Warmed());
    IsolationResult& warm = warmed.result;
    if (!warm.returned_to_nominal) {
      const bool explains_more =
          warm.verdict.kind == VerdictKind::kFault && !result.verdict.sensor &&
          (result.verdict.kind == VerdictKind::kUnknownFault ||
           warm.present.size() < result.present.size() ||
           (BySpeedAlone() && warmed.cost + kFaultGain < cold.cost) ||
           (heals && !NamesAnotherInstead(warm) && warmed.cost < cold.cost + kFaultGain));
      return explains_more ? warm : result;
    }
    if (!maybe_healthy) return result;
    warm.warmed = true;
    warm.verdict.reason = WarmingSentence(Eigen::Map<const Eigen::VectorXd>(
        warm.shift.data(), static_cast<Eigen::Index>(warm.shift.size())));
    return warm;
  }

  IsolationResult Empty() const {
    IsolationResult result;
    result.id = task_.id;
    result.verdict.detected_at_s = task_.alarm_t_s;
    result.verdict.detector = task_.detector;
    result.verdict.settled = task_.settled;
    return result;
  }

  struct Conclusion {
    IsolationResult result;
    Explanation explanation;
    bool second = false;  // beside the faults that were known
    double cost = 0.0;    // of the best fit
    double strain = 0.0;  // what it pays of that because the coordinates are off their prior
  };

  Conclusion Conclude(const FitContext& nominal) {
    FitContext on_top = nominal;
    for (const Candidate& fault : task_.reference) {
      on_top.rig = WithComponent(on_top.rig, fault.component, fault.value);
    }
    held_ = !task_.reference.empty() && HardlyTurns(on_top.rig, on_top.stretch);
    if (held_) {
      changeable_.clear();
      for (const Candidate& fault : task_.reference) changeable_.push_back(fault.component);
    }
    Explanation explanation = Explain(nominal, changeable_, task_, readings_);
    bool second = false;
    if (!task_.reference.empty() && !held_ && explanation.gain >= kFaultGain) {
      Explanation added = Explain(on_top, changeable_, task_, readings_);
      const HypothesisFit& another = added.set.best();
      const double share =
          std::abs(std::log(another.value / on_top.rig.plant.Get(another.component)));
      if (share > kSecondFaultShare &&
          another.cost + kSecondFaultCost < explanation.set.best().cost) {
        explanation = std::move(added);
        second = true;
      }
    }
    return Told(std::move(explanation), second);
  }

  Conclusion Told(Explanation explanation, bool second) const {
    IsolationResult result = Empty();
    FillVerdict(explanation, second, result);
    const HypothesisFit& best = explanation.set.best();
    const GaussianPrior& prior = explanation.context.calibration;
    const Eigen::VectorXd off = best.nuisance - prior.mean;
    const double cost = best.cost;
    const double strain = off.dot(prior.information * off);
    return {std::move(result), std::move(explanation), second, cost, strain};
  }

  // A drift that is too steep for the newest second: what one value leaves of the whole stretch is
  // far more than noise, and the newest value is another. (Coulomb friction looks like B, and in
  // 0.4 s nothing tells them apart.)
  Conclusion Steep(Conclusion unknown) {
    constexpr double kScoreMin = 4.0;
    constexpr double kSigmas = 5.0;
    const Explanation& whole = unknown.explanation;
    const HypothesisFit& nearest = whole.set.best();
    if (nearest.chi2 < kScoreMin * nearest.count) return unknown;
    std::optional<Explanation> steep =
        ExplainSteep(whole.context, changeable_, task_, readings_, nearest.component);
    if (!steep) return unknown;
    const HypothesisFit& last = steep->set.best();
    const double way = std::abs(std::log(last.value / nearest.value));
    if (last.bound != 0 || way < kSigmas * last.log_sigma) return unknown;
    return Told(std::move(*steep), unknown.second);
  }

  // Rare impulses, or hum that nobody could follow.
  Conclusion WithoutOddReadings(Conclusion unknown) {
    const Explanation& found = unknown.explanation;
    const bool known = !unknown.second;
    const HypothesisFit* nearest = known ? &found.set.best() : nullptr;
    const HypothesisFit* newest = known && found.of_newest ? &*found.of_newest : nullptr;
    if (readings_.LeaveOutRare(nominal_, nearest, newest)) {
      if (std::optional<Conclusion> without = Explained()) return std::move(*without);
    }
    readings_.PutBack();
    if (readings_.TakeOutHum(nominal_)) {
      if (std::optional<Conclusion> without = Explained()) return std::move(*without);
    }
    readings_.PutBack();
    return unknown;
  }

  std::optional<Conclusion> Explained() {
    Conclusion conclusion = Conclude(nominal_);
    const IsolationResult& result = conclusion.result;
    const bool explained = result.verdict.kind == VerdictKind::kFault || result.returned_to_nominal;
    return explained ? std::optional(std::move(conclusion)) : std::nullopt;
  }

  // What comes at once is no warming. What is left when the reading that has raised the alarm is
  // left out did not come at once.
  bool IsSlow() const { return task_.detector.starts_with("glr") || AlarmLeftOut(); }

  bool AlarmLeftOut() const { return readings_.HasLeftOut(task_.alarm_at); }

  bool BySpeedAlone() const { return !task_.calibration->used_um && !task_.calibration->used_ia; }

  // No part heals while another fails: the fault that was known is more likely on a rig that has
  // warmed up meanwhile.
  bool NamesAnotherInstead(const IsolationResult& result) const {
    const std::vector<Component>& group = result.verdict.group;
    return IsSlow() && task_.options.bench->norm.warming > 0.0 && task_.reference.size() == 1 &&
           result.verdict.kind == VerdictKind::kFault && result.present.size() == 1 &&
           std::find(group.begin(), group.end(), task_.reference.front().component) == group.end();
  }

  // By the speed alone, a fault that needs a rig far off what was learnt may be another one of a
  // rig that has warmed up.
  bool IsStrained(const Conclusion& cold) const {
    return BySpeedAlone() && task_.options.bench->norm.warming > 0.0 && cold.strain > kStrained &&
           cold.result.verdict.kind == VerdictKind::kFault;
  }

  // A small change (the component that comes nearest to a warming need not be one that warms up),
  // a hardly visible one, or something that no component explains.
  bool MayBeWarming(const IsolationResult& result) const {
    const Bench& bench = *task_.options.bench;
    if (!IsSlow() || bench.norm.warming <= 0.0 || result.returned_to_nominal) return false;
    // A magnet that warms up reads like a sensor that is off a little.
    if (result.verdict.sensor) return true;
    // um alone does not show it; there only a part that is named may be one.
    const bool shows = task_.calibration->used_ia || task_.calibration->used_n;
    if (shows &&
        (result.verdict.kind == VerdictKind::kUnknownFault || result.gain < kHardlyVisible)) {
      return true;
    }
    const PlantParameters& healthy = nominal_.rig.plant;
    const auto within = [&](const Candidate& each) {
      const double change = std::abs(std::log(each.value / healthy.Get(each.component)));
      return IsWithinWarming(bench.norm, healthy, each) || (shows && change < bench.norm.warming);
    };
    const std::vector<Component>& group = result.verdict.group;
    const auto& candidates = result.verdict.candidates;
    return std::any_of(result.present.begin(), result.present.end(), within) ||
           std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& each) {
             return within(each) &&
                    std::find(group.begin(), group.end(), each.component) != group.end();
           });
  }

  // The rig as it may be after it has warmed up since it was learnt, and as the record before the
  // alarm shows it.
  FitContext Warmed() const {
    constexpr double kLongS = 600.0;
    const BenchNorm& norm = task_.options.bench->norm;
    const Calibration& learnt = *task_.calibration;
    const double since_s = task_.alarm_t_s < learnt.to_s
                               ? -1.0
                               : task_.alarm_t_s - 0.5 * (learnt.from_s + learnt.to_s);
    FitContext warm = nominal_;
    warm.calibration = PriorOf(learnt);
    Widen(norm, since_s >= 0.0 ? since_s : kLongS, warm.calibration);
    if (readings_.history().empty()) return warm;
    UpdatePosterior(readings_.history(), warm);
    const double fitted_s =
        static_cast<double>(warm.stretch.size() + Span(kHistoryGap)) * task_.options.period_s;
    Widen(norm, fitted_s, warm.calibration);
    return warm;
  }

  std::size_t Span(std::size_t samples) const { return SpanOf(samples, task_.options.period_s); }

  // The noise that the calibration has found includes the rounding of the healthy motor's speed.
  void AllowForRounding() {
    const double step_s = task_.options.bench->n.step_s;
    if (step_s <= 0.0) return;
    const double more = AddedRounding(nominal_.ModelOf(nominal_.rig), step_s, nominal_.stretch);
    nominal_.noise.w_rad_s = std::sqrt(nominal_.noise.w_rad_s * nominal_.noise.w_rad_s + more);
  }

  void FillVerdict(const Explanation& explanation, bool second, IsolationResult& result) const {
    Verdict& verdict = result.verdict;
    const RankedHypotheses& set = explanation.set;
    const HypothesisFit& best = set.best();
    const double score = best.chi2 / std::max(1, best.count);
    result.gain = explanation.gain;
    result.shape = explanation.shape;
    // What no listed component explains is nominal only if the nominal rig does, about.
    const HypothesisFit& null = explanation.null;
    if (explanation.gain < kFaultGain && null.chi2 <= kNominalScoreMax * null.count) {
      result.returned_to_nominal = true;
      const Eigen::VectorXd& moved = explanation.null.nuisance;
      result.shift.assign(moved.data(), moved.data() + moved.size());
      verdict.kind = VerdictKind::kNominal;
      verdict.reason = "what follows the alarm fits the nominal rig";
      return;
    }
    for (const HypothesisFit& fit : set.fits) {
      verdict.candidates.push_back(ToCandidate(fit, score));
      const bool close = fit.rank_cost() - best.rank_cost() < kNotExcludedCost;
      const bool same = task_.options.values == ValuePrior::kNone && fit.cost - best.cost < 1e3 &&
                        PredictionDistance(explanation.context, best, fit) < kSamePrediction;
      if (&fit == &best || close || same) verdict.group.push_back(fit.component);
    }
    result.shift.assign(best.nuisance.data(), best.nuisance.data() + best.nuisance.size());
    if (second) result.present = task_.reference;
    result.present.push_back(verdict.candidates.front());

    if (explanation.sensor) {
      verdict.kind = VerdictKind::kUnknownFault;
      verdict.group.clear();
      verdict.sensor = explanation.sensor->change;
      verdict.reason = SensorSentence(*verdict.sensor);
      return;
    }
    if (!explanation.lack_of_fit.adequate && !held_) {
      verdict.kind = VerdictKind::kUnknownFault;
      verdict.group.clear();
      verdict.reason = "no single component explains the record";
      LackOfFit lack_of_fit = explanation.lack_of_fit;
      if (!lack_of_fit.relaxed) TestRelaxed(explanation.context, best, lack_of_fit);
      if (!lack_of_fit.beside.empty()) {
        verdict.reason +=
            ": beside " + std::string(Name(best.component)) + " also " + lack_of_fit.beside;
      }
      return;
    }
    verdict.kind = VerdictKind::kFault;
    verdict.reason = FaultSentence(verdict);
    if (best.response && !second) {
      verdict.response = ResponseChange{SpeedResponseOf(*task_.calibration), *best.response};
    }
    if (explanation.shape == FaultShape::kDrift) {
      verdict.reason += RateText(best.component, explanation.rate);
    }
    if (held_) verdict.reason += "; the motor hardly turns, so that nothing more can be told";
    if (second) verdict.reason += ", on top of " + ValueText(task_.reference.front());
    if (set.off_list && explanation.shape == FaultShape::kAbrupt) {
      verdict.reason += "; no relay position has this value";
    }
    if (!task_.calibration->used_ia || !task_.calibration->used_n) {
      verdict.reason +=
          "; with " + ChannelsOf(*task_.calibration) + " alone a double fault cannot be excluded";
    }
    if (explanation.shape != FaultShape::kAbrupt) return;
    result.onset = task_.onset ? *task_.onset : FindOnset(explanation);
    verdict.onset_s = result.onset->t_s;
    if (second && result.onset->all_along) {
      // The fault covers the whole history, so it began together with the other one.
      verdict.kind = VerdictKind::kUnknownFault;
      verdict.reason = "two components have changed together: " + FaultSentence(verdict) + " and " +
                       ValueText(task_.reference.front());
      verdict.group.clear();
    }
  }

  Onset FindOnset(const Explanation& explanation) const {
    const std::size_t alarm = std::min(task_.alarm_at, readings_.all().size() - 1);
    const std::size_t begin = alarm - std::min(alarm, Span(kOnsetHistory));
    RigParameters before = nominal_.rig;
    for (const Candidate& fault : task_.reference) {
      before = WithComponent(before, fault.component, fault.value);
    }
    const HypothesisFit& best = explanation.set.best();
    const RigParameters after =
        WithComponent(WithOffsets(explanation.context.rig, best.nuisance, nominal_.period_s),
                      best.component,
                      best.value);
    const std::size_t onset =
        begin + EstimateOnset(before,
                              after,
                              nominal_.noise,
                              nominal_.period_s,
                              best.component.info().kind == PartKind::kCapacitor,
                              readings_.all().subspan(begin),
                              alarm - begin);
    return {task_.samples[std::min(onset, task_.samples.size() - 1)].t_s,
            onset - begin <= Span(kAllAlong)};
  }

  const IsolationTask& task_;
  std::vector<Component> changeable_;
  CleanReadings readings_;
  FitContext nominal_;
  /// The faults that are known already hold the motor near rest (HardlyTurns): only their own
  /// values are told from then on.
  bool held_ = false;
};

}  // namespace

IsolationResult Isolate(const IsolationTask& task) {
  LAB_CHECK(task.calibration != nullptr);
  return Isolation(task).Run();
}

}  // namespace faultlab::core
