// Fuzzy rules on the paper's coefficients (paper section 1, [6, 12, 39, 40]). Inputs: log ratios of
// b0, b1, a1 and b1/a1 to their healthy means, by SIA with K = `tuning`. Each is `less`, `same` or
// `more` by trapezoids between 1 and 3 widths, a width being its healthy standard deviation, at
// least 5 %. One rule for each component and eight changes of it, derived from Eq. (4):
//   IF b0 is s1 AND b1 is s2 AND a1 is s3 AND b1/a1 is s4 THEN the component has grown (shrunk)
// Strength: the least membership (Mamdani). Detection: the largest distance in widths.
// Identification: the value whose coefficients by Eq. (4) are nearest in the logarithms.
// Isolation: the strongest rule, less the distance that its value leaves.
// Source: E. H. Mamdani, S. Assilian, Int. J. Man-Machine Stud. 7 (1975); Eq. (4): core/plant.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/methods/estimate_bands.h"
#include "core/methods/hypotheses.h"
#include "core/methods/method_list.h"
#include "core/paper/paper_methods.h"

namespace faultlab::core {
namespace {

using Inputs = std::array<double, 4>;  // log b0, log b1, log a1, log b1/a1, as ratios to healthy
constexpr double kWidthMin = 0.05;
constexpr int kAny = 2;  // the rule does not ask for this input

Inputs Ratios(const ContinuousTheta& theta, const ContinuousTheta& healthy) {
  const auto log_ratio = [&](std::size_t i) {
    const double ratio = theta[i] / healthy[i];
    return std::log(std::max(ratio, 1e-6));
  };
  return {log_ratio(0), log_ratio(1), log_ratio(2), log_ratio(1) - log_ratio(2)};
}

/// Membership of a distance in `less` (-1), `same` (0), `more` (1).
double Membership(double widths, int sign) {
  if (sign == kAny) return 1.0;
  const double more = std::clamp((widths - 1.0) / 2.0, 0.0, 1.0);
  const double less = std::clamp((-widths - 1.0) / 2.0, 0.0, 1.0);
  return sign > 0 ? more : sign < 0 ? less : 1.0 - std::max(more, less);
}

class FuzzyRules : public Method {
 public:
  explicit FuzzyRules(const MethodTask& task)
      : task_(task),
        bands_(task_, FirstOrderSpec(task_, task.tuning, PaperIntegral(task.tuning), false)) {
    const Calibration& known = task_.calibration;
    nominal_ = FirstOrderTheta(known.nominal, known.gain_factor);
    for (std::size_t i = 0; i < 3; ++i) {
      width_[i] = std::max(kWidthMin, bands_.sd()[i] / std::abs(bands_.mean()[i]));
    }
    width_[3] = std::hypot(width_[1], width_[2]);
    // The factors by which a rule's component has changed.
    constexpr std::array kChanges = {1e-3, 0.01, 0.1, 0.4, 2.5, 10.0, 50.0, 200.0};
    for (const Component component : task_.bench->components()) {
      const double visible =
          std::max(std::exp(LogStart(task_, component)), component.info().least_visible);
      for (const double factor : kChanges) {
        PlantParameters changed = known.nominal;
        changed.Set(component, factor * visible);
        const Inputs off = Ratios(FirstOrderTheta(changed, known.gain_factor), nominal_);
        Rule rule{component, {}};
        for (std::size_t i = 0; i < off.size(); ++i) {
          const bool same = std::abs(off[i]) < kWidthMin;
          const bool clear = std::abs(off[i]) > 3.0 * kWidthMin;
          rule.sign[i] = same ? 0 : !clear ? kAny : off[i] > 0.0 ? 1 : -1;
        }
        const bool any = std::any_of(
            rule.sign.begin(), rule.sign.end(), [](int sign) { return sign == 1 || sign == -1; });
        if (any) rules_.push_back(rule);
      }
    }
  }

  void Push(const Sample& sample, const Observation&) override {
    bands_.Push(sample);
    if (!bands_.usable()) return;
    statistic_ = 0.0;
    const Inputs now = Ratios(bands_.theta(), bands_.mean());
    for (std::size_t i = 0; i < now.size(); ++i) {
      statistic_ = std::max(statistic_, std::abs(now[i]) / width_[i]);
    }
  }
  double statistic() const override { return statistic_; }
  MethodFinding Diagnose() override {
    MethodFinding finding{Answer::kNotYet, Answer::kNotYet, {}, 0};
    if (!bands_.usable()) return finding;
    const Inputs now = Ratios(bands_.theta(), bands_.mean());
    for (const Component component : task_.bench->components()) {
      double strongest = 0.0;
      for (const Rule& rule : rules_) {
        if (!(rule.component == component)) continue;
        double strength = 1.0;
        for (std::size_t i = 0; i < now.size(); ++i) {
          strength = std::min(strength, Membership(now[i] / width_[i], rule.sign[i]));
        }
        strongest = std::max(strongest, strength);
      }
      if (strongest <= 0.0) continue;
      MethodCandidate candidate = SearchValue(component, [&](Component c, double log_value) {
        PlantParameters changed = task_.calibration.nominal;
        changed.Set(c, std::exp(log_value));
        const Inputs there =
            Ratios(FirstOrderTheta(changed, task_.calibration.gain_factor), nominal_);
        double sum = 0.0;
        for (std::size_t i = 0; i < 3; ++i) sum += (there[i] - now[i]) * (there[i] - now[i]);
        return sum;
      });
      candidate.cost = std::sqrt(candidate.cost) - strongest;
      finding.candidates.push_back(candidate);
    }
    constexpr double kSame = 1e-3;
    FinishFinding(kSame, true, finding);
    return finding;
  }
  std::size_t bytes() const override { return sizeof *this + rules_.size() * sizeof(Rule); }

 private:
  struct Rule {
    Component component;
    std::array<int, 4> sign;
  };

  MethodTask task_;
  EstimateBands bands_;
  ContinuousTheta nominal_{};
  std::array<double, 4> width_{};
  std::vector<Rule> rules_;
  double statistic_ = 0.0;
};

}  // namespace

std::unique_ptr<Method> MakeFuzzyRules(const MethodTask& task) {
  return std::make_unique<FuzzyRules>(task);
}

}  // namespace faultlab::core
