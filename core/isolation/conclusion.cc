#include "core/isolation/conclusion.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "core/filter/speed_response.h"
#include "core/isolation/friction_hold.h"
#include "core/isolation/lack_of_fit.h"
#include "core/isolation/onset.h"
#include "core/isolation/verdict_text.h"
#include "core/types/number_text.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Squared distance of whitened predictions per sample, below which an hour of data would not
// distinguish two hypotheses (3.6e5 samples x 2e-5 = 7).
constexpr double kSamePrediction = 2e-5;

// Gain that a fault needs to go on: it is known, so nothing is chosen.
constexpr double kKnownFaultGain = 6.0;
// Near rest as many times the noise are noise to the detector, in standard deviations.
constexpr double kHeldNoise = 2.0;
// Where more than so many times the noise is left, the motor is no longer at rest.
constexpr double kHeldLost = 30.0;
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

// While the motor turned, more told the components apart than friction lets see near rest.
void PreferWhatWasFound(const IsolationTask& task, Explanation& explanation) {
  std::vector<HypothesisFit>& fits = explanation.set.fits;
  const HypothesisFit best = fits.front();
  if (task.AgreesWithFound(best.component) || !BringsToRest(explanation.context, best)) return;
  const auto found = std::find_if(fits.begin(), fits.end(), [&](const HypothesisFit& fit) {
    return task.AgreesWithFound(fit.component) && IsAlikeNearRest(best, fit, true) &&
           BringsToRest(explanation.context, fit);
  });
  if (found != fits.end()) std::rotate(fits.begin(), found, found + 1);
}

std::string SentenceOf(const OutsideFit& outside) {
  return outside.sensor ? SensorSentence(*outside.sensor) : FrictionSentence(*outside.friction);
}

/// A channel that has read the same number to its last digit from some row on to the newest, while
/// the input moved, and never so long before: a driver that hangs. A counter repeats itself all the
/// time, and a motor that stands still reads 0: they say nothing by it.
struct DeadChannel {
  const char* name;
  double from_s;
};

std::optional<DeadChannel> FindDeadChannel(const IsolationTask& task) {
  constexpr std::size_t kSameMin = 50;
  constexpr std::size_t kUsualMost = 5;
  constexpr double kMovesMin = 0.1;
  constexpr std::pair<const char*, double Sample::*> kChannels[] = {
      {"um", &Sample::um_v}, {"ia", &Sample::ia_a}, {"n", &Sample::n_rpm}};
  const bool used[] = {
      task.calibration->used_um, task.calibration->used_ia, task.calibration->used_n};
  const std::vector<Sample>& samples = task.samples;
  const std::size_t same_min = SpanOf(kSameMin, task.options.period_s);
  for (std::size_t c = 0; c < std::size(kChannels); ++c) {
    const auto& [name, reading] = kChannels[c];
    if (!used[c] || samples.empty() || samples.back().*reading == 0.0) continue;
    std::size_t run = 0;      // the one that ends at k
    std::size_t longest = 0;  // of those before it
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const bool same = k > 0 && samples[k].*reading == samples[k - 1].*reading;
      if (!same) longest = std::max(longest, std::exchange(run, 0));
      run += std::isfinite(samples[k].*reading) ? 1 : 0;
    }
    const bool was_alive = samples.size() > 2 * same_min && samples.size() - run >= same_min &&
                           longest > 0 && longest <= kUsualMost;
    if (run < same_min || !was_alive) continue;
    const auto held = std::span(samples).last(run);
    const auto [low, high] = std::ranges::minmax(held, {}, &Sample::uc_v);
    const bool moves = high.uc_v - low.uc_v > kMovesMin * std::abs(high.uc_v);
    if (moves) return DeadChannel{name, held.front().t_s};
  }
  return std::nullopt;
}

class Telling {
 public:
  Telling(const Explanation& explanation, std::size_t beneath, const ToldAbout& about)
      : explanation_(explanation),
        best_(explanation.set.best()),
        beneath_(beneath),
        about_(about),
        task_(about.task),
        held_((about.held && StillFits()) ||
              (task_.AgreesWithFound(best_.component) && BringsToRest(explanation.context, best_))),
        moved_on_(HasMovedOn()),
        shape_(moved_on_ ? FaultShape::kDrift : explanation.shape) {}

  IsolationResult Run() const {
    IsolationResult result = Unanswered(task_);
    result.gain = explanation_.gain;
    result.shape = shape_;
    if (IsNominal()) {
      TellNominal(result);
      return result;
    }
    Rank(result);
    Verdict& verdict = result.verdict;
    if (explanation_.outside) {
      verdict.sensor = explanation_.outside->sensor;
      verdict.friction = explanation_.outside->friction;
    }
    if (const std::optional<DeadChannel> dead = FindDeadChannel(task_)) {
      verdict.sensor = SensorChange{dead->name, SensorChange::Kind::kLost, kAbsent, kAbsent};
      verdict.candidates.clear();
      TellUnknown(
          SensorSentence(*verdict.sensor) +
              Format("; it reads the same number since %.2f s, to the last digit", dead->from_s),
          verdict);
    } else if (explanation_.is_outside) {
      TellUnknown(SentenceOf(*explanation_.outside), verdict);
    } else if (!explanation_.lack_of_fit.adequate && !held_) {
      TellUnknown(Unexplained(), verdict);
    } else {
      TellFault(result);
    }
    return result;
  }

 private:
  // What no listed component explains is nominal only if the nominal rig does, about.
  bool IsNominal() const {
    const HypothesisFit& null = explanation_.null;
    const bool goes_on = GoesOn();
    const bool little = explanation_.gain < (goes_on ? kKnownFaultGain : kFaultGain) ||
                        (!task_.reference.empty() && beneath_ == 0 && !goes_on && IsHardlyOff());
    return little && null.chi2 <= kNominalScoreMax * null.count;
  }

  double HealthyValue() const { return about_.nominal.rig.plant.Get(best_.component); }

  // A fault that was known is still there: nearer to what it was than to a healthy part.
  bool GoesOn() const {
    const std::vector<Candidate>& known = task_.reference;
    return std::any_of(known.begin(), known.end(), [&](const Candidate& each) {
      return each.component == best_.component &&
             std::abs(std::log(best_.value / each.value)) <
                 std::abs(std::log(best_.value / HealthyValue()));
    });
  }

  bool HasMovedOn() const {
    const std::vector<Candidate>& known = task_.reference;
    return task_.has_moved && best_.component == known.back().component &&
           beneath_ + 1 == known.size();
  }

  // The fault that was known is gone, and what is left is an error of it.
  bool IsHardlyOff() const {
    const double off = std::log(best_.value / HealthyValue());
    if (best_.bound != 0) return (best_.bound == '<') == (off > 0.0);
    return std::abs(off) < std::max(kErrorShare, best_.log_sigma);
  }

  bool WasAlike(const HypothesisFit& fit) const {
    const std::vector<Component>& alike = task_.alike_at_rest;
    return std::find(alike.begin(), alike.end(), fit.component) != alike.end();
  }

  bool StillFits() const { return best_.chi2 < kHeldLost * best_.count; }

  void TellNominal(IsolationResult& result) const {
    result.returned_to_nominal = true;
    SetShift(explanation_.null, result);
    result.verdict.kind = VerdictKind::kNominal;
    result.verdict.reason = "what follows the alarm fits the nominal rig";
  }

  void SetShift(const HypothesisFit& fit, IsolationResult& result) const {
    const FitContext& context = explanation_.context;
    result.shift.assign(fit.nuisance.data(), fit.nuisance.data() + context.calibrated());
    if (context.direct_is_free) {
      result.direct_factor = std::exp(fit.nuisance(context.calibrated()));
    }
  }

  // Candidates, and those of them that nothing tells apart from the best.
  void Rank(IsolationResult& result) const {
    Verdict& verdict = result.verdict;
    const double score = best_.chi2 / std::max(1, best_.count);
    result.sure = best_.bound == 0 && !explanation_.outside;
    for (const HypothesisFit& fit : explanation_.set.fits) {
      verdict.candidates.push_back(ToCandidate(fit, score));
      const bool close = fit.rank_cost() - best_.rank_cost() < kNotExcludedCost;
      const bool same = task_.options.values == ValuePrior::kNone && fit.cost - best_.cost < 1e3 &&
                        PredictionDistance(explanation_.context, best_, fit) < kSamePrediction;
      const bool alike = held_ && (WasAlike(fit) || IsAlikeNearRest(best_, fit, about_.held));
      const bool excluded =
          held_ && !task_.AgreesWithFound(fit.component) && task_.AgreesWithFound(best_.component);
      if (&fit == &best_ || ((close || same || alike) && !excluded)) {
        verdict.group.push_back(fit.component);
        result.sure = result.sure && (&fit == &best_ || same);
      }
    }
    SetProbabilities(verdict.candidates);
    SetShift(best_, result);
    const auto known = task_.reference.begin();
    result.present.assign(known, known + static_cast<std::ptrdiff_t>(beneath_));
    result.present.push_back(verdict.candidates.front());
    result.samples = explanation_.shape == FaultShape::kAbrupt
                         ? about_.readings.since_fault().size()
                         : explanation_.context.stretch.size();
  }

  // Laplace's approximation: the prior of a value is as wide for each component (MagnitudePrior).
  // "None of them" is the sensor or the friction that is not excluded, or the relaxed fit, which
  // pays for all that it may move.
  void SetProbabilities(std::vector<Candidate>& candidates) const {
    const std::vector<HypothesisFit>& fits = explanation_.set.fits;
    const double best = best_.rank_cost();
    double sum = 0.0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      candidates[i].probability = std::exp(std::min(0.5 * (best - fits[i].rank_cost()), 300.0));
      sum += candidates[i].probability;
    }
    double excess = ExcessOfNone();
    if (explanation_.outside) {
      excess = std::max(excess, best_.rank_cost() - explanation_.outside->evidence);
    }
    sum += std::exp(std::min(0.5 * excess, 300.0)) * candidates.front().probability;
    for (Candidate& each : candidates) each.probability /= sum;
  }

  // By how much "none of them" costs less than the best.
  double ExcessOfNone() const {
    const LackOfFit& judged = explanation_.lack_of_fit;
    const double relaxed = judged.relaxed_gain - kRelaxedGainMax;
    return judged.adequate ? std::min(relaxed, -kNotExcludedCost)
                           : std::max(relaxed, kNotExcludedCost);
  }

  static void TellUnknown(std::string reason, Verdict& verdict) {
    verdict.kind = VerdictKind::kUnknownFault;
    verdict.group.clear();
    verdict.reason = std::move(reason);
  }

  std::string Unexplained() const {
    LackOfFit lack_of_fit = explanation_.lack_of_fit;
    if (!lack_of_fit.relaxed) TestRelaxed(explanation_.context, best_, lack_of_fit);
    std::string reason = "no single component explains the record";
    if (lack_of_fit.beside.empty()) return reason;
    return reason + ": beside " + std::string(Name(best_.component)) + " also " +
           lack_of_fit.beside;
  }

  std::string ReasonOfFault(const Verdict& verdict) const {
    const bool abrupt = shape_ == FaultShape::kAbrupt;
    std::string reason = FaultSentence(verdict);
    if (!abrupt) reason += RateText(best_.component, explanation_.rate);
    if (about_.held || !explanation_.lack_of_fit.adequate)
      reason += "; the motor hardly turns, so that nothing more can be told";
    for (std::size_t k = 0; k < beneath_; ++k) {
      reason += (k == 0 ? ", on top of " : " and ") + ValueText(task_.reference[k]);
    }
    if (explanation_.set.off_list && abrupt) reason += "; no relay position has this value";
    if (explanation_.outside) reason += "; or " + SentenceOf(*explanation_.outside);
    return reason + NotExcluded("two faults at once are");
  }

  std::string NotExcluded(const std::string& what) const {
    if (task_.calibration->used_ia && task_.calibration->used_n) return {};
    return "; with " + ChannelsOf(*task_.calibration) + " alone, " + what + " possible too";
  }

  void TellFault(IsolationResult& result) const {
    Verdict& verdict = result.verdict;
    verdict.kind = VerdictKind::kFault;
    result.adequate = explanation_.lack_of_fit.adequate;
    result.moved_on = moved_on_;
    verdict.reason = ReasonOfFault(verdict);
    if (held_)
      result.noise_factor = kHeldNoise * std::sqrt(std::max(1.0, verdict.candidates.front().score));
    if (best_.response && beneath_ == 0) {
      verdict.response = ResponseChange{SpeedResponseOf(*task_.calibration), *best_.response};
    }
    if (shape_ == FaultShape::kDrift) {
      result.moves = explanation_.rate != 0.0;
      return;
    }
    result.onset = task_.onset ? *task_.onset : FindOnset();
    verdict.onset_s = result.onset->t_s;
    if (beneath_ == 0 || !result.onset->all_along || GoesOn()) return;
    // The fault covers the whole history, so it began together with the other one.
    TellUnknown("two components have changed together: " + FaultSentence(verdict) + " and " +
                    ValueText(task_.reference.front()) + NotExcluded("another pair is"),
                verdict);
  }

  std::size_t Span(std::size_t samples) const { return SpanOf(samples, task_.options.period_s); }

  Onset FindOnset() const {
    const std::size_t alarm = std::min(task_.alarm_at, about_.readings.all().size() - 1);
    const std::size_t begin = alarm - std::min(alarm, Span(kOnsetHistory));
    RigParameters before = about_.nominal.rig;
    for (const Candidate& fault : task_.reference) {
      before = WithComponent(before, fault.component, fault.value);
    }
    const RigParameters after =
        WithComponent(explanation_.context.RigAt(best_.nuisance), best_.component, best_.value);
    const std::size_t onset =
        begin + EstimateOnset(before,
                              after,
                              about_.nominal.noise,
                              about_.nominal.period_s,
                              best_.component.info().kind == PartKind::kCapacitor,
                              about_.readings.all().subspan(begin),
                              alarm - begin);
    return {task_.samples[std::min(onset, task_.samples.size() - 1)].t_s,
            onset - begin <= Span(kAllAlong)};
  }

  const Explanation& explanation_;
  const HypothesisFit& best_;
  const std::size_t beneath_;
  const ToldAbout& about_;
  const IsolationTask& task_;
  const bool held_;
  const bool moved_on_;
  const FaultShape shape_;
};

}  // namespace

IsolationResult Unanswered(const IsolationTask& task) {
  IsolationResult result;
  result.id = task.id;
  result.early = task.early;
  result.verdict.detected_at_s = task.alarm_t_s;
  result.verdict.detector = task.detector;
  result.verdict.settled = task.settled;
  return result;
}

Conclusion Told(Explanation explanation, std::size_t beneath, const ToldAbout& about) {
  PreferWhatWasFound(about.task, explanation);
  IsolationResult result = Telling(explanation, beneath, about).Run();
  const HypothesisFit& best = explanation.set.best();
  const double cost = best.cost;
  return {std::move(result), std::move(explanation), beneath, cost};
}

}  // namespace faultlab::core
