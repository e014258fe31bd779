#include "core/isolation/isolation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <limits>
#include <string>

#include "core/filter/impulses.h"
#include "core/filter/speed_response.h"
#include "core/isolation/friction_hold.h"
#include "core/isolation/lack_of_fit.h"
#include "core/isolation/onset.h"
#include "core/isolation/ranked_hypotheses.h"
#include "core/isolation/sensor_hypotheses.h"
#include "core/isolation/speed_rounding.h"
#include "core/isolation/verdict_text.h"
#include "core/isolation/warming.h"
#include "core/types/check.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Counts of samples are for 100 Hz; faster records use more samples for the same time (SpanOf).

// Gain in -2 log p over "nothing changed" that a fault needs; it includes the choice among all
// faults.
constexpr double kFaultGain = 14.0;
// Hypotheses within this cost of the best one are not excluded: three standard deviations.
constexpr double kNotExcludedCost = 9.0;
// Squared distance of whitened predictions per sample, below which an hour of data would not
// distinguish two hypotheses (3.6e5 samples x 2e-5 = 7).
constexpr double kSamePrediction = 2e-5;
// Penalty for the extra parameter of a fault on top of another one.
constexpr double kSecondFaultCost = 20.0;
// Less than this share is the error of the first one's value, of the calibration or of the model.
constexpr double kSecondFaultShare = 0.03;
// Readings that are fitted at most (the newest): enough for every target, and it bounds the time.
constexpr std::size_t kReadingsMax = 1200;
// Number of hypotheses whose values are estimated again from all readings since the fault, after
// the newest readings have decided which component it is.
constexpr std::size_t kSizedMax = 2;
// When one value does not explain the stretch, its newest part may still follow one value, or a
// slope.
constexpr std::size_t kLateSamples = 200;
constexpr std::size_t kDriftSamples = 100;
constexpr std::size_t kLateMin = 60;
constexpr std::size_t kDriftHypotheses = 3;
// A component is not tried as a drift if its best constant value costs this much more than the best
// component's.
constexpr double kDriftWorthCost = 3000.0;
// History that updates the prior: long enough, and ending well before the fault may have begun.
constexpr std::size_t kHistoryMin = 100;
constexpr std::size_t kHistoryGap = 50;
// History that is searched for the onset.
constexpr std::size_t kOnsetHistory = 120;
constexpr std::size_t kAllAlong = 10;
// A sensor is named when no component comes within this of it, in cost; it is tried where it may
// come within the second of the best component.
constexpr double kSensorLead = 9.0;
constexpr double kSensorWorthCost = 300.0;
// Residuals of twice the noise may be noise that has grown, as that of hum which beats with the
// rate.
constexpr double kNominalScoreMax = 4.0;

template <int n>
GaussianPrior PriorOf(const double* numbers) {
  using Square = Eigen::Matrix<double, n, n>;
  const Eigen::Map<const Square> covariance(numbers);
  const Square regular = covariance + 1e-12 * Square::Identity();
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(n);
  prior.information = regular.ldlt().solve(Square::Identity());
  return prior;
}

GaussianPrior PriorOf(const Calibration& calibration) {
  const std::vector<double>& covariance = calibration.covariance;
  if (covariance.size() == kCoordinateMax * kCoordinateMax) {
    return PriorOf<kCoordinateMax>(covariance.data());
  }
  if (covariance.size() == kCoordinateCountWithLa * kCoordinateCountWithLa) {
    return PriorOf<kCoordinateCountWithLa>(covariance.data());
  }
  LAB_CHECK(covariance.size() == kCoordinateCount * kCoordinateCount, covariance.size());
  return PriorOf<kCoordinateCount>(covariance.data());
}

// Empty unless it is of all coordinates.
Eigen::MatrixXd SquareOf(const std::vector<double>& numbers, const Calibration& calibration) {
  if (numbers.size() != calibration.covariance.size()) return {};
  const auto n = std::lround(std::sqrt(static_cast<double>(numbers.size())));
  return Eigen::Map<const Eigen::MatrixXd>(numbers.data(), n, n);
}

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

// One answer about the stretch after the alarm.
struct Explanation {
  FitContext context;
  RankedHypotheses set;
  LackOfFit lack_of_fit;
  FaultShape shape = FaultShape::kAbrupt;
  HypothesisFit null{};               ///< the same stretch without a new fault
  std::optional<SensorFit> sensor{};  ///< explains the stretch better than any component
  double gain = 0.0;  ///< of cost, compared with the same stretch without a new fault
  double rate = 0.0;  ///< of a drift that goes on: SI units of the component a second
};

class Isolation {
 public:
  explicit Isolation(const IsolationTask& task)
      : task_(task),
        observations_(MakeObservations(task.samples,
                                       task.options.bench->readings(),
                                       task.options.channels,
                                       task.options.period_s,
                                       task.options.um_rail_v,
                                       ZerosOf(*task.calibration))) {
    nominal_.rig = ParametersOf(*task.calibration);
    nominal_.noise = NoiseOf(*task.calibration);
    nominal_.calibration = PriorOf(*task.calibration);
    nominal_.tolerance_covariance =
        SquareOf(task.calibration->tolerance_covariance, *task.calibration);
    nominal_.model_covariance = SquareOf(task.calibration->model_covariance, *task.calibration);
    nominal_.part_tolerance = task.calibration->part_tolerance;
    nominal_.period_s = task.options.period_s;
    nominal_.follow_noise = task.options.bench->fits_follow_noise;
    const std::size_t n = observations_.size();
    const auto channels = static_cast<std::size_t>(std::popcount(task.calibration->mask()));
    const std::size_t from =
        std::max(std::min(task.fit_from, n), n - std::min(n, Span(kReadingsMax) / channels));
    nominal_.stretch = std::span<const Observation>(observations_).subspan(from);
    since_fault_ = std::span<const Observation>(observations_).subspan(std::min(task.fit_from, n));
    if (task.calibration->impulse_share > 0.0) {
      in_newest_ = ImpulseRule{};
      LeaveOutAllImpulses(std::min(task.fit_from, n));
    }
    UpdateFromHistory(std::min(task.fit_from, n));
    AllowForRounding();
  }

  IsolationResult Run() {
    if (nominal_.stretch.size() < 2) {
      IsolationResult result = Empty();
      result.returned_to_nominal = true;
      result.verdict.kind = VerdictKind::kNominal;
      result.verdict.settled = false;
      result.verdict.reason = "too few samples after the alarm";
      return result;
    }
    IsolationResult result = Conclude(nominal_);
    if (result.verdict.kind == VerdictKind::kUnknownFault && !result.verdict.sensor) {
      result = WithoutRareImpulses(std::move(result));
    }
    if (!MayBeWarming(result)) return result;
    IsolationResult warm = Conclude(Warmed());
    if (!warm.returned_to_nominal) {
      const bool explains_more = warm.verdict.kind == VerdictKind::kFault &&
                                 (result.verdict.kind == VerdictKind::kUnknownFault ||
                                  warm.present.size() < result.present.size());
      return explains_more ? warm : result;
    }
    warm.warmed = true;
    warm.verdict.reason = WarmingSentence(Eigen::Map<const Eigen::VectorXd>(
        warm.shift.data(), static_cast<Eigen::Index>(warm.shift.size())));
    return warm;
  }

 private:
  IsolationResult Empty() const {
    IsolationResult result;
    result.id = task_.id;
    result.verdict.detected_at_s = task_.alarm_t_s;
    result.verdict.detector = task_.detector;
    result.verdict.settled = task_.settled;
    return result;
  }

  IsolationResult Conclude(const FitContext& nominal) {
    IsolationResult result = Empty();
    FitContext on_top = nominal;
    for (const Candidate& fault : task_.reference) {
      on_top.rig = WithComponent(on_top.rig, fault.component, fault.value);
    }
    held_ = !task_.reference.empty() && HardlyTurns(on_top.rig, on_top.stretch);
    if (held_) {
      changeable_.clear();
      for (const Candidate& fault : task_.reference) changeable_.push_back(fault.component);
    }
    Explanation explanation = ExplainFrom(nominal);
    bool second = false;
    if (!task_.reference.empty() && !held_ && explanation.gain >= kFaultGain) {
      Explanation added = ExplainFrom(on_top);
      const HypothesisFit& another = added.set.best();
      const double share =
          std::abs(std::log(another.value / on_top.rig.plant.Get(another.component)));
      if (share > kSecondFaultShare &&
          another.cost + kSecondFaultCost < explanation.set.best().cost) {
        explanation = std::move(added);
        second = true;
      }
    }
    FillVerdict(explanation, second, result);
    return result;
  }

  // Impulses may be so rare that the healthy stretch had none.
  IsolationResult WithoutRareImpulses(IsolationResult unknown) {
    if (task_.calibration->impulse_share > 0.0) return unknown;
    const std::vector<Observation> before = observations_;
    // So far that nothing else can be behind them, and so few.
    constexpr ImpulseRule kRare{.gate = 12.0, .share_max = 0.02};
    in_newest_ = kRare;
    const std::size_t of_all =
        LeaveOutSinceFault(std::min(task_.fit_from, observations_.size()), kRare);
    (void)Newest(nominal_, Span(kLateSamples));
    if (of_all > 0 || left_out_of_newest_ > 0) {
      IsolationResult without = Conclude(nominal_);
      const bool explained =
          without.verdict.kind == VerdictKind::kFault || without.returned_to_nominal;
      if (explained) return without;
    }
    std::copy(before.begin(), before.end(), observations_.begin());
    in_newest_.reset();
    return unknown;
  }

  // A small change of Ra, Ke or B among the faults, or something that no component explains and
  // that moves one of them.
  bool MayBeWarming(const IsolationResult& result) const {
    const Bench& bench = *task_.options.bench;
    // What comes at once is no warming.
    const bool slow = task_.detector.starts_with("glr");
    if (!slow || bench.norm.warming <= 0.0 || result.returned_to_nominal || result.verdict.sensor) {
      return false;
    }
    if (result.verdict.kind == VerdictKind::kUnknownFault &&
        (result.moved.find("Ra") != std::string::npos ||
         result.moved.find("the motor constant") != std::string::npos)) {
      return true;
    }
    return std::any_of(result.present.begin(), result.present.end(), [&](const Candidate& each) {
      return IsWithinWarming(bench, each);
    });
  }

  // The rig as it may be after it has warmed up since it was learnt, and as the record before the
  // alarm shows it.
  FitContext Warmed() const {
    constexpr double kLongS = 600.0;
    const BenchNorm& norm = task_.options.bench->norm;
    const double since_s = task_.alarm_t_s - task_.calibration->to_s;
    FitContext warm = nominal_;
    warm.calibration = PriorOf(*task_.calibration);
    Widen(norm, since_s >= 0.0 ? since_s : kLongS, warm.calibration);
    const std::size_t fit_from = std::min(task_.fit_from, observations_.size());
    if (!HistoryTells(fit_from)) return warm;
    UpdatePosterior(std::span<const Observation>(observations_).first(fit_from - Span(kHistoryGap)),
                    warm);
    const double fitted_s =
        static_cast<double>(warm.stretch.size() + Span(kHistoryGap)) * task_.options.period_s;
    Widen(norm, fitted_s, warm.calibration);
    return warm;
  }

  bool HistoryTells(std::size_t fit_from) const {
    return task_.reference.empty() && fit_from >= Span(kHistoryMin) + Span(kHistoryGap);
  }

  std::size_t Span(std::size_t samples) const { return SpanOf(samples, task_.options.period_s); }

  // Before the fault by the calibrated rig; after it by the component that comes nearest, which no
  // single reading decides.
  void LeaveOutAllImpulses(std::size_t fit_from) {
    const std::span<Observation> all(observations_);
    if (task_.reference.empty()) {
      LeaveOutImpulses(nominal_.ModelOf(nominal_.rig), all.first(fit_from));
    }
    if (nominal_.stretch.size() < 2) return;
    LeaveOutSinceFault(fit_from, {.or_the_farthest = true});
  }

  std::size_t LeaveOutSinceFault(std::size_t fit_from, const ImpulseRule& rule) {
    return LeaveOut(nominal_, std::span<Observation>(observations_).subspan(fit_from), rule);
  }

  // What is left out decides what comes nearest, and the other way round.
  // @param context  of a stretch that shares its readings with `readings`
  std::size_t LeaveOut(const FitContext& context,
                       std::span<Observation> readings,
                       const ImpulseRule& rule) const {
    constexpr int kRounds = 4;
    std::size_t all = 0;
    for (int round = 0; round < kRounds; ++round) {
      const HypothesisFit nearest = Fit(context, FitPolicy::kStopLosers).best();
      const RigParameters rig = WithOffsets(context.rig, nearest.nuisance, context.period_s);
      const std::size_t more = LeaveOutImpulses(
          context.ModelOf(WithComponent(rig, nearest.component, nearest.value)), readings, rule);
      if (more == 0) break;
      all += more;
    }
    return all;
  }

  // The noise that the calibration has found includes the rounding of the healthy motor's speed.
  void AllowForRounding() {
    const double step_s = task_.options.bench->n.step_s;
    if (step_s <= 0.0) return;
    const double more = AddedRounding(nominal_.ModelOf(nominal_.rig), step_s, nominal_.stretch);
    nominal_.noise.w_rad_s = std::sqrt(nominal_.noise.w_rad_s * nominal_.noise.w_rad_s + more);
  }

  // The record before the alarm is healthy too, and longer than the calibration's stretch at times.
  void UpdateFromHistory(std::size_t fit_from) {
    if (!HistoryTells(fit_from)) return;
    UpdatePosterior(std::span<const Observation>(observations_).first(fit_from - Span(kHistoryGap)),
                    nominal_);
  }

  RankedHypotheses Fit(const FitContext& context, FitPolicy policy) const {
    return RankHypotheses(context, changeable_, task_.options.values, policy);
  }

  // Of a record that moves, no component comes near the whole: there, impulses hide behind what it
  // leaves. In the newest part they stand out again.
  FitContext Newest(const FitContext& context, std::size_t samples) {
    FitContext late = context;
    late.stretch = context.stretch.last(std::min(samples, context.stretch.size()));
    if (!in_newest_) return late;
    std::vector<Observation>& part = newest_.emplace_back(late.stretch.begin(), late.stretch.end());
    late.stretch = part;
    left_out_of_newest_ += LeaveOut(late, part, *in_newest_);
    return late;
  }

  Explanation ExplainFrom(const FitContext& context) {
    Explanation explanation = Explain(context);
    const double cost = explanation.sensor ? explanation.sensor->cost : explanation.set.best().cost;
    explanation.null = FitNullHypothesis(explanation.context);
    explanation.gain = explanation.null.cost - cost;
    return explanation;
  }

  std::optional<SensorFit> SensorBetterThan(const HypothesisFit& best,
                                            const FitContext& context) const {
    if (!task_.reference.empty()) return std::nullopt;
    std::optional<SensorFit> sensor = BestSensor(context, best.cost + kSensorWorthCost);
    const bool better =
        sensor && sensor->cost + kSensorLead < best.cost && FitsNoise(sensor->chi2, sensor->count);
    return better ? sensor : std::nullopt;
  }

  // 0 where it is not far beyond its error.
  double RateOf(const FitContext& slope, const DriftFit& moving) const {
    constexpr double kSigmas = 4.0;
    const double change = moving.fit.value - moving.first_value;
    if (std::abs(change) < kSigmas * moving.fit.value * moving.fit.log_sigma) return 0.0;
    return change / (static_cast<double>(slope.stretch.size()) * task_.options.period_s);
  }

  // Tries one value for the whole stretch; then one value for its newest part; then a slope.
  Explanation Explain(const FitContext& context) {
    Explanation whole{context, Fit(context, FitPolicy::kFitAll), {}, FaultShape::kAbrupt};
    whole.lack_of_fit = TestLackOfFit(context, whole.set.best());
    whole.sensor = SensorBetterThan(whole.set.best(), context);
    if (whole.sensor) return whole;
    if (whole.lack_of_fit.adequate) SizeWithAll(whole);
    const std::size_t n = context.stretch.size();
    if (whole.lack_of_fit.adequate || n < Span(kLateMin)) return whole;
    if (n > Span(kLateSamples)) {
      const FitContext late = Newest(context, Span(kLateSamples));
      Explanation newest{late, Fit(late, FitPolicy::kStopLosers), {}, FaultShape::kDrift};
      newest.lack_of_fit = TestLackOfFit(late, newest.set.best());
      if (newest.lack_of_fit.adequate) {
        const FitContext slope = Newest(context, Span(kDriftSamples));
        newest.rate = RateOf(slope, FitDrift(slope, newest.set.best()));
        return newest;
      }
    }
    const FitContext slope = Newest(context, Span(kDriftSamples));
    Explanation drift{slope, Fit(slope, FitPolicy::kStopLosers), {}, FaultShape::kDrift};
    std::vector<HypothesisFit>& fits = drift.set.fits;
    const double constant_cost = drift.set.best().cost;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < std::min(kDriftHypotheses, fits.size()); ++i) {
      if (fits[i].cost - constant_cost > kDriftWorthCost) break;
      const DriftFit moving = FitDrift(slope, fits[i]);
      fits[i] = moving.fit;
      if (moving.fit.cost < least) {
        least = moving.fit.cost;
        drift.rate = RateOf(slope, moving);
      }
    }
    std::sort(fits.begin(), fits.end(), LikelierFirst);
    drift.lack_of_fit = TestScore(fits.front());
    if (drift.lack_of_fit.adequate && constant_cost - fits.front().cost > kFaultGain) return drift;
    return whole;
  }

  // Estimates value and standard error of the best hypotheses from every reading since the fault;
  // their order is already decided.
  void SizeWithAll(Explanation& whole) const {
    if (!task_.settled || task_.options.values != ValuePrior::kNone ||
        since_fault_.size() <= whole.context.stretch.size()) {
      return;
    }
    FitContext all = whole.context;
    all.stretch = since_fault_;
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
      result.moved = lack_of_fit.moved;
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
    const std::size_t alarm = std::min(task_.alarm_at, observations_.size() - 1);
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
                              std::span<const Observation>(observations_).subspan(begin),
                              alarm - begin);
    return {task_.samples[std::min(onset, task_.samples.size() - 1)].t_s,
            onset - begin <= Span(kAllAlong)};
  }

  const IsolationTask& task_;
  std::vector<Observation> observations_;
  std::optional<ImpulseRule> in_newest_;         ///< what is left out of a newest part
  std::deque<std::vector<Observation>> newest_;  ///< such parts
  std::size_t left_out_of_newest_ = 0;           ///< readings
  FitContext nominal_;
  std::span<const Observation> since_fault_;
  std::vector<Component> changeable_ = Changeable(task_.options);
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
