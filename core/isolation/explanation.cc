#include "core/isolation/explanation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/isolation/friction_hold.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Number of hypotheses whose values are estimated again from all readings since the fault, after
// the newest readings have decided which component it is.
constexpr std::size_t kSizedMax = 2;
// The newest part may follow a slope; a steep one is a slope for a shorter time.
struct Slope {
  std::size_t samples;
  std::size_t block;  ///< as FitDrift
  bool may_stand;     ///< the value need not move any more: a steep one has mostly ended
};
constexpr Slope kGentle{100, kDriftBlock, false};
constexpr Slope kSteep{40, 2, true};
constexpr std::size_t kLateMin = 60;
constexpr std::size_t kDriftHypotheses = 3;
// What a slope gains over one value where it is told: four standard deviations.
constexpr double kMovesGain = 16.0;
// A component is not tried as a drift if its best constant value costs this much more than the best
// component's.
constexpr double kDriftWorthCost = 3000.0;
// A sensor, or friction, is tried where it may come within this of the best component, in cost.
constexpr double kOutsideWorthCost = 300.0;

class Search {
 public:
  Search(const std::vector<Component>& components,
         const IsolationTask& task,
         CleanReadings& readings)
      : components_(components), task_(task), readings_(readings) {}

  Explanation Run(const FitContext& context) { return WithGain(BestOf(context)); }

  std::optional<Explanation> RunSteep(const FitContext& context, Component component) const {
    std::optional<Explanation> drift = Moving(context, kSteep);
    if (!drift || drift->set.best().component != component) return std::nullopt;
    return WithGain(std::move(*drift));
  }

 private:
  static Explanation WithGain(Explanation explanation) {
    const double cost =
        explanation.is_outside ? explanation.outside->cost : explanation.set.best().cost;
    explanation.null = FitNullHypothesis(explanation.context);
    explanation.gain = explanation.null.cost - cost;
    return explanation;
  }

  std::size_t Span(std::size_t samples) const { return SpanOf(samples, task_.options.period_s); }

  RankedHypotheses Fit(const FitContext& context, FitPolicy policy) const {
    return RankHypotheses(context, components_, task_.options.values, policy);
  }

  // Friction near rest is more than Coulomb's, and a gain there is that of next to nothing: a motor
  // tells nothing of them. A tachometer that is dead looks like rest, too, and the others tell.
  std::optional<OutsideFit> OutsideNear(const HypothesisFit& best,
                                        const FitContext& context) const {
    if (!task_.reference.empty()) return std::nullopt;
    std::optional<OutsideFit> outside =
        BestOutside(context, best.cost + kOutsideWorthCost, !BringsToRest(context, best));
    const bool near = outside && outside->evidence < best.rank_cost() + kNotExcludedCost &&
                      FitsNoise(outside->chi2, outside->count);
    return near ? outside : std::nullopt;
  }

  double RateOf(const FitContext& slope, const DriftFit& moving) const {
    const double change = moving.fit.value - moving.first_value;
    return change / (static_cast<double>(slope.stretch.size()) * task_.options.period_s);
  }

  // 0 where it is not far beyond the error of the value. (That of a change is smaller.)
  double CertainRate(const FitContext& slope, const DriftFit& moving) const {
    constexpr double kSigmas = 4.0;
    const double change = moving.fit.value - moving.first_value;
    if (std::abs(change) < kSigmas * moving.fit.value * moving.fit.log_sigma) return 0.0;
    return RateOf(slope, moving);
  }

  // A motor at rest that is told to be what it was not while it turned: its stretch begins too
  // early, or shows too little.
  void TestAgainstFound(Explanation& told) const {
    const HypothesisFit& best = told.set.best();
    if (!task_.AgreesWithFound(best.component) && BringsToRest(told.context, best)) {
      told.lack_of_fit.adequate = false;
    }
  }

  Explanation BestOf(const FitContext& context) {
    Explanation whole{context, Fit(context, FitPolicy::kFitAll), {}, FaultShape::kAbrupt};
    whole.lack_of_fit = TestLackOfFit(context, whole.set.best());
    whole.outside = OutsideNear(whole.set.best(), context);
    whole.is_outside =
        whole.outside && whole.outside->evidence + kNotExcludedCost < whole.set.best().rank_cost();
    if (whole.is_outside) return whole;
    TestAgainstFound(whole);
    if (whole.lack_of_fit.adequate) SizeWithAll(whole);
    const std::size_t n = context.stretch.size();
    if (whole.lack_of_fit.adequate || n < Span(kLateMin)) return whole;
    if (n > Span(kLateSamples)) {
      const FitContext late = readings_.Newest(context, Span(kLateSamples));
      Explanation newest{late, Fit(late, FitPolicy::kStopLosers), {}, FaultShape::kDrift};
      newest.lack_of_fit = TestLackOfFit(late, newest.set.best());
      TestAgainstFound(newest);
      if (newest.lack_of_fit.adequate) {
        const FitContext slope = readings_.Newest(context, Span(kGentle.samples));
        newest.rate = CertainRate(slope, FitDrift(slope, newest.set.best()));
        return newest;
      }
      if (!BringsToRest(context, whole.set.best()) && BringsToRest(late, newest.set.best())) {
        return newest;
      }
      whole.of_newest = newest.set.best();
    }
    std::optional<Explanation> drift = Moving(context, kGentle);
    return drift ? std::move(*drift) : std::move(whole);
  }

  // The newest part with a value that moves, if that explains it.
  std::optional<Explanation> Moving(const FitContext& context, const Slope& shape) const {
    const FitContext slope = readings_.Newest(context, Span(shape.samples));
    Explanation drift{slope, Fit(slope, FitPolicy::kStopLosers), {}, FaultShape::kDrift};
    std::vector<HypothesisFit>& fits = drift.set.fits;
    const double constant_cost = drift.set.best().cost;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < std::min(kDriftHypotheses, fits.size()); ++i) {
      if (fits[i].cost - constant_cost > kDriftWorthCost) break;
      const DriftFit moving = FitDrift(slope, fits[i], shape.block);
      const bool moves = fits[i].cost - moving.fit.cost > kMovesGain;
      fits[i] = moving.fit;
      if (moving.fit.cost < least) {
        least = moving.fit.cost;
        drift.rate = moves ? RateOf(slope, moving) : 0.0;
      }
    }
    std::sort(fits.begin(), fits.end(), LikelierFirst);
    drift.lack_of_fit = TestScore(fits.front());
    TestAgainstFound(drift);
    const bool moves = constant_cost - fits.front().cost > kFaultGain;
    if (!drift.lack_of_fit.adequate || !(moves || shape.may_stand)) return std::nullopt;
    return drift;
  }

  // Estimates value and standard error of the best hypotheses from every reading since the fault;
  // their order is already decided.
  void SizeWithAll(Explanation& whole) const {
    if (!task_.settled || task_.options.values != ValuePrior::kNone ||
        readings_.since_fault().size() <= whole.context.stretch.size()) {
      return;
    }
    FitContext all = whole.context;
    all.stretch = readings_.since_fault();
    std::vector<HypothesisFit>& fits = whole.set.fits;
    const double best_cost = fits.front().cost;
    for (std::size_t i = 0; i < std::min(kSizedMax, fits.size()); ++i) {
      if (fits[i].cost - best_cost > kNotExcludedCost || fits[i].bound != 0) continue;
      HypothesisFit sized = fits[i];
      RefineComponent(all, sized);
      if (!TestScore(sized).adequate || sized.bound != 0) continue;
      fits[i].value = sized.value;
      fits[i].log_sigma = sized.log_sigma;
      fits[i].nuisance = sized.nuisance;
    }
  }

  const std::vector<Component>& components_;
  const IsolationTask& task_;
  CleanReadings& readings_;
};

}  // namespace

Explanation Explain(const FitContext& context,
                    const std::vector<Component>& components,
                    const IsolationTask& task,
                    CleanReadings& readings) {
  return Search(components, task, readings).Run(context);
}

std::optional<Explanation> ExplainSteep(const FitContext& context,
                                        const std::vector<Component>& components,
                                        const IsolationTask& task,
                                        CleanReadings& readings,
                                        Component component) {
  return Search(components, task, readings).RunSteep(context, component);
}

}  // namespace faultlab::core
