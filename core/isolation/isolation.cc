#include "core/isolation/isolation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "core/isolation/clean_readings.h"
#include "core/isolation/conclusion.h"
#include "core/isolation/explanation.h"
#include "core/isolation/friction_hold.h"
#include "core/isolation/nominal_context.h"
#include "core/isolation/speed_rounding.h"
#include "core/isolation/warming.h"
#include "core/numerics/linear_systems.h"
#include "core/types/check.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Counts of samples are for 100 Hz; faster records use more samples for the same time (SpanOf).

// Penalty for the extra parameter of a fault on top of another one.
constexpr double kSecondFaultCost = 20.0;
// Cost by which the nominal rig must beat a fault that was found, to have it withdrawn: as much as
// a known fault needs to go on.
constexpr double kRefuted = 6.0;

std::vector<Component> Changeable(const IsolationOptions& options) {
  std::vector<Component> components;
  for (Component component : options.bench->components()) {
    if (IsSwitched(component) || options.motor_faults) components.push_back(component);
  }
  return components;
}

// The part that has taken the place of a healthy one is known as its fault was measured.
void LoosenBy(const Candidate& fault, FitContext& context) {
  const int own = CoordinateOf(fault.component.info(), context.rig.plant);
  if (own < 0 || fault.bound != 0) return;
  GaussianPrior& prior = context.calibration;
  Eigen::MatrixXd covariance = CovarianceOf(prior.information);
  covariance.row(own).setZero();
  covariance.col(own).setZero();
  covariance(own, own) = std::pow(fault.sigma / fault.value, 2);
  prior.information = InverseOfSymmetric(covariance);
  prior.mean(own) = 0.0;
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
    result.shows_neither = result.returned_to_nominal && !result.warmed && FoundStillFits();
    return result;
  }

 private:
  IsolationResult Concluded() {
    if (nominal_.stretch.size() < 2) {
      IsolationResult result = Unanswered(task_);
      result.returned_to_nominal = true;
      result.verdict.kind = VerdictKind::kNominal;
      result.verdict.settled = false;
      result.verdict.reason = "too few samples after the alarm";
      return result;
    }
    Conclusion cold = Conclude(nominal_);
    if (IsUnexplained(cold)) {
      cold = WithoutOddReadings(std::move(cold));
      if (!IsOutside(cold.result.verdict) && !cold.explanation.lack_of_fit.adequate)
        cold = Steep(std::move(cold));
    }
    cold = CapacitorAlone(std::move(cold));
    IsolationResult& result = cold.result;
    if (!MayBeWarming(result)) return result;
    Conclusion warmed = Conclude(Warmed());
    IsolationResult& warm = warmed.result;
    if (!warm.returned_to_nominal) {
      const bool explains_more = warm.verdict.kind == VerdictKind::kFault &&
                                 !IsOutside(result.verdict) &&
                                 (result.verdict.kind == VerdictKind::kUnknownFault ||
                                  warm.present.size() < result.present.size() ||
                                  (BySpeedAlone() && warmed.cost + kFaultGain < cold.cost));
      return explains_more ? warm : result;
    }
    if (KeepsItsFault(result)) return result;
    warm.warmed = true;
    warm.verdict.reason = WarmingSentence(Eigen::Map<const Eigen::VectorXd>(
        warm.shift.data(), static_cast<Eigen::Index>(warm.shift.size())));
    return warm;
  }

  bool FoundStillFits() const {
    if (task_.found.empty() || nominal_.stretch.size() < 2) return false;
    const FitContext found = OnTop(nominal_, task_.found);
    return FitNullHypothesis(found).cost < FitNullHypothesis(nominal_).cost + kRefuted;
  }

  // Readings that are odd alone may be all that a sensor has lost.
  static bool IsUnexplained(const Conclusion& conclusion) {
    const Verdict& verdict = conclusion.result.verdict;
    return verdict.kind == VerdictKind::kUnknownFault &&
           (!IsOutside(verdict) ||
            (verdict.sensor && verdict.sensor->kind == SensorChange::Kind::kLost));
  }

  Conclusion Conclude(const FitContext& nominal) {
    const std::size_t known = task_.reference.size();
    held_ = known > 0 && HardlyTurns(OnTop(nominal, task_.reference).rig, nominal.stretch);
    if (held_) {
      changeable_ = task_.alike;
      for (const Candidate& fault : task_.reference) {
        if (std::find(changeable_.begin(), changeable_.end(), fault.component) ==
            changeable_.end()) {
          changeable_.push_back(fault.component);
        }
      }
    }
    Explanation explanation = Explain(nominal, changeable_, task_, readings_);
    std::size_t beneath = 0;
    // The last one that is known may go on, on top of the others, and another may have come.
    for (std::size_t k = 1; k <= known && !held_ && explanation.gain >= kFaultGain; ++k) {
      const FitContext on_top = OnTop(nominal, std::span(task_.reference).first(k));
      Explanation added = Explain(on_top, changeable_, task_, readings_);
      const HypothesisFit& another = added.set.best();
      const double share =
          std::abs(std::log(another.value / on_top.rig.plant.Get(another.component)));
      if (share > kErrorShare &&
          another.rank_cost() + kSecondFaultCost < explanation.set.best().rank_cost()) {
        explanation = std::move(added);
        beneath = k;
      }
    }
    return Told(std::move(explanation), beneath, About());
  }

  static FitContext OnTop(const FitContext& nominal, std::span<const Candidate> faults) {
    FitContext on_top = nominal;
    for (const Candidate& fault : faults) {
      on_top.rig = WithComponent(on_top.rig, fault.component, fault.value);
      LoosenBy(fault, on_top);
    }
    return on_top;
  }

  ToldAbout About() const { return {task_, nominal_, readings_, held_}; }

  // A drift that is too steep for the newest second: what one value leaves is far more than noise,
  // and the newest value is another. (Coulomb friction looks like B, and in 0.4 s nothing tells
  // them apart.) Of a long stretch that moves, the component that comes nearest to the newest part
  // counts too.
  Conclusion Steep(Conclusion unknown) {
    const Explanation& whole = unknown.explanation;
    for (const HypothesisFit* nearest :
         {&whole.set.best(), whole.of_newest ? &*whole.of_newest : nullptr}) {
      if (nearest == nullptr) continue;
      if (std::optional<Explanation> steep = SteepFrom(whole.context, *nearest)) {
        return Told(std::move(*steep), unknown.beneath, About());
      }
    }
    return unknown;
  }

  std::optional<Explanation> SteepFrom(const FitContext& context, const HypothesisFit& nearest) {
    constexpr double kScoreMin = 4.0;
    constexpr double kMovedCost = 25.0;  // five standard deviations
    if (nearest.chi2 < kScoreMin * nearest.count) return std::nullopt;
    std::optional<Explanation> steep =
        ExplainSteep(context, changeable_, task_, readings_, nearest.component);
    if (!steep || steep->set.best().bound != 0) return std::nullopt;
    const double healthy = context.rig.plant.Get(nearest.component);
    const double last = steep->set.best().value;
    if ((nearest.value > healthy) != (last > healthy)) return std::nullopt;
    FitContext still = steep->context;
    still.rig = WithComponent(still.rig, nearest.component, nearest.value);
    const double moved = FitNullHypothesis(still).cost - steep->set.best().cost;
    if (moved < kMovedCost) return std::nullopt;
    return steep;
  }

  // Rare impulses, or hum that nobody could follow.
  Conclusion WithoutOddReadings(Conclusion unknown) {
    const Explanation& found = unknown.explanation;
    const bool known = unknown.beneath == 0;
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

  // A capacitor, and something beside it that may be no more than the resistors around it: nothing
  // has shown before what they are off.
  Conclusion CapacitorAlone(Conclusion found) {
    const Verdict& verdict = found.result.verdict;
    const bool unexplained = verdict.kind == VerdictKind::kUnknownFault && !IsOutside(verdict);
    const auto is_capacitor = [](Component component) {
      return component.info().kind == PartKind::kCapacitor;
    };
    const bool known =
        std::any_of(task_.reference.begin(), task_.reference.end(), [&](const Candidate& each) {
          return is_capacitor(each.component);
        });
    const bool in_play = known || is_capacitor(found.explanation.set.best().component);
    if (!(unexplained || found.beneath > 0) || !in_play || nominal_.part_tolerance <= 0.0)
      return found;
    Conclusion another = Conclude(WithFreeDirect(nominal_));
    const bool alone = another.result.verdict.kind == VerdictKind::kFault && another.beneath == 0 &&
                       is_capacitor(another.explanation.set.best().component);
    return alone ? std::move(another) : std::move(found);
  }

  std::optional<Conclusion> Explained() {
    Conclusion conclusion = Conclude(nominal_);
    const IsolationResult& result = conclusion.result;
    // A motor that is held at rest is told whatever is left: that explains nothing.
    const bool fits = conclusion.explanation.lack_of_fit.adequate;
    const bool explained = (result.verdict.kind == VerdictKind::kFault && fits) ||
                           IsOutside(result.verdict) || result.returned_to_nominal;
    return explained ? std::optional(std::move(conclusion)) : std::nullopt;
  }

  // What comes at once is no warming. What is left when the reading that has raised the alarm is
  // left out did not come at once.
  bool IsSlow() const { return SeesSmallChanges(task_.detector) || AlarmLeftOut(); }

  bool AlarmLeftOut() const { return readings_.HasLeftOut(task_.alarm_at); }

  bool BySpeedAlone() const { return !task_.calibration->used_um && !task_.calibration->used_ia; }

  // The fault that was known is still there: more than warming does.
  bool KeepsItsFault(const IsolationResult& result) const {
    if (result.verdict.kind != VerdictKind::kFault) return false;
    const auto known = [&](const Candidate& each) {
      return std::any_of(task_.reference.begin(), task_.reference.end(), [&](const Candidate& one) {
        return one.component == each.component &&
               !IsWithinWarming(task_.options.bench->norm, nominal_.rig.plant, each);
      });
    };
    return std::all_of(result.present.begin(), result.present.end(), known);
  }

  // A small change (the component that comes nearest to a warming need not be one that warms up),
  // or something that no component explains.
  bool MayBeWarming(const IsolationResult& result) const {
    const Bench& bench = *task_.options.bench;
    if (!IsSlow() || bench.norm.warming <= 0.0 || result.returned_to_nominal) return false;
    // A magnet that warms up reads like a sensor that is off a little, and grease like less
    // friction.
    if (IsOutside(result.verdict)) return true;
    // um alone does not show it; there only a part that is named may be one.
    const bool shows = task_.calibration->used_ia || task_.calibration->used_n;
    if (shows && result.verdict.kind == VerdictKind::kUnknownFault) return true;
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

  const IsolationTask& task_;
  std::vector<Component> changeable_;
  CleanReadings readings_;
  FitContext nominal_;
  /// The faults that are known already hold the motor near rest (HardlyTurns): from then on only
  /// they are told, and what nothing told apart from them.
  bool held_ = false;
};

}  // namespace

IsolationResult Isolate(const IsolationTask& task) {
  LAB_CHECK(task.calibration != nullptr);
  return Isolation(task).Run();
}

}  // namespace faultlab::core
