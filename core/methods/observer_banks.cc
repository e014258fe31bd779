// Banks of observers (paper section 1, [7, 14, 27, 28]): one observer for each component and value
// of a grid over its range, x <- Step(model, x) + injection of e = y - yhat. Three injections:
//   Luenberger    L e, L by pole placement for speed and slow torque: their poles are `tuning`
//                 times those of the model (J. Ackermann's formula for 2 x 2)
//   Kalman        K e, K of the settled Riccati recursion; its noise is `tuning` times the
//                 calibrated one
//   sliding mode  K band sat(e / band), band = `tuning` standard deviations of e: inside the band
//   it
//                 is linear, outside the correction is bounded (discrete quasi-sliding mode)
// Detection: CUSUM of e of the healthy observer, scaled to its healthy variance.
// Isolation: sum of e^2 / variance + log variance since the alarm, least over the values of each
// component. Identification: the parabola through the three values around the least.
// Source: D. G. Luenberger, IEEE Trans. Autom. Control 16 (1971); P. S. Maybeck, Stochastic Models
// 2 (1982), section 10.8 (multiple models); C. Edwards, S. Spurgeon, R. Patton, Automatica 36
// (2000).
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/isolation/profile_cost.h"
#include "core/methods/hypotheses.h"
#include "core/methods/method_list.h"
#include "core/methods/steady_filter.h"

namespace faultlab::core {
namespace {

enum class Injection { kLuenberger, kKalman, kSlidingMode };

// (w, d) of the model observed through the fitted channel after a prediction; the current follows
// within a period:  error+ = (A - L c phi) error, so the pair (A, c phi) is placed.
Eigen::Vector4d PlacedGain(const PredictionModel& model, int row, double share) {
  const Eigen::Matrix2d a = model.phi.bottomRightCorner<2, 2>();
  const Eigen::Vector2d c = (model.c.row(row) * model.phi).tail<2>().transpose();
  Eigen::Matrix2d observability;
  observability << c.transpose(), (c.transpose() * a).eval();
  const double det = observability.determinant();
  if (!(std::abs(det) > 1e-18)) return Eigen::Vector4d::Zero();
  const double p = share * a(0, 0);
  const double q = share * a(1, 1);
  const Eigen::Matrix2d wanted = a * a - (p + q) * a + p * q * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d last = observability.fullPivLu().solve(Eigen::Vector2d(0.0, 1.0));
  Eigen::Vector4d gain = Eigen::Vector4d::Zero();
  gain.tail<2>() = wanted * last;
  return gain;
}

// Observers stand this much closer than the points of a scan, so that the nearest one of the true
// component is nearer than any of another.
constexpr int kFiner = 4;
int PointsOf(const ValueRange& range) {
  return kFiner * (range.points - 1) + 1;
}
double LogAt(const ValueRange& range, int point) {
  const double step = (range.LogAt(1) - range.LogAt(0)) / kFiner;
  return range.LogAt(0) + point * step;
}

class ObserverBank : public Method {
 public:
  ObserverBank(const MethodTask& task, Injection injection)
      : task_(task), injection_(injection), healthy_(Observer(WatchedModel(task))) {
    double squares = 0.0;
    double count = 0.0;
    const std::size_t settle = task.healthy.size() / 4;
    for (std::size_t k = 0; k < task.healthy.size(); ++k) {
      const double e = Advance(healthy_, task.healthy[k]);
      if (k < settle || !task_.Has(task.healthy[k])) continue;
      squares += e * e;
      count += 1.0;
    }
    if (squares > 0.0) scale_ = std::sqrt(count / squares);
  }

  void Push(const Sample&, const Observation& o) override {
    if (bank_.empty()) {
      const double e = Advance(healthy_, o);
      if (task_.Has(o)) cusum_.Push(e * scale_);
      return;
    }
    constexpr double kMemory =
        0.99;                      // of the cost, a sample: an observer that began wrong catches up
    constexpr int kSettling = 20;  // samples until the observers have forgotten the other plant
    ++since_;
    for (std::size_t i = 0; i < bank_.size(); ++i) {
      const double e = Advance(bank_[i], o);
      const double z = e * (injection_ == Injection::kKalman ? bank_[i].inverse_sd : scale_);
      if (task_.Has(o) && since_ > kSettling) {
        costs_[i] = kMemory * costs_[i] + (std::isfinite(z) ? z * z : 1e9);
        if (injection_ == Injection::kKalman) costs_[i] -= 2.0 * std::log(bank_[i].inverse_sd);
      }
    }
  }
  double statistic() const override { return cusum_.g; }
  void OnAlarm() override {
    for (const Component component : task_.bench->components()) {
      const ValueRange range = RangeOf(component);
      first_.push_back(bank_.size());
      for (int i = 0; i < PointsOf(range); ++i) {
        bank_.push_back(Observer(ModelOf(task_, component, LogAt(range, i))));
        bank_.back().x = healthy_.x;
      }
    }
    costs_.assign(bank_.size(), 0.0);
  }
  MethodFinding Diagnose() override {
    MethodFinding finding;
    const std::vector<Component> components = task_.bench->components();
    for (std::size_t c = 0; c < first_.size(); ++c) {
      const ValueRange range = RangeOf(components[c]);
      const auto begin = costs_.begin() + static_cast<std::ptrdiff_t>(first_[c]);
      const auto best = std::min_element(begin, begin + PointsOf(range));
      const auto at = static_cast<int>(best - begin);
      double shift = 0.0;
      double least = *best;
      if (at > 0 && at + 1 < PointsOf(range)) {
        const double left = *(best - 1) - *best;
        const double right = *(best + 1) - *best;
        if (left + right > 0.0) shift = 0.5 * (left - right) / (left + right);
        least -= 0.25 * (left - right) * shift;
      }
      const double step = LogAt(range, 1) - LogAt(range, 0);
      finding.candidates.push_back(
          {components[c], std::exp(LogAt(range, at) + shift * step), least});
    }
    if (since_ == 0) finding.candidates.clear();
    FinishFinding(0.0, true, finding);
    return finding;
  }
  std::size_t bytes() const override {
    return sizeof *this + bank_.size() * sizeof(SteadyFilter) + costs_.size() * sizeof(double);
  }

 private:
  SteadyFilter Observer(PredictionModel model) const {
    if (injection_ == Injection::kKalman) {
      for (double& variance : model.reading_variance) variance *= task_.tuning * task_.tuning;
    }
    SteadyFilter filter = SettledKalman(task_, model);
    if (injection_ == Injection::kLuenberger) {
      filter.gain = PlacedGain(model, task_.channel(), task_.tuning);
    }
    return filter;
  }
  double Advance(SteadyFilter& filter, const Observation& o) const {
    const double e = filter.Predict(task_, o);
    double injected = e;
    if (injection_ == Injection::kSlidingMode) {
      const double band = task_.tuning / filter.inverse_sd;
      injected = std::clamp(e, -band, band);
    }
    filter.x += filter.gain * injected;
    return e;
  }

  MethodTask task_;
  Injection injection_;
  SteadyFilter healthy_;
  double scale_ = 1.0;
  SquareCusum cusum_;
  std::vector<SteadyFilter> bank_;
  std::vector<double> costs_;
  std::vector<std::size_t> first_;  ///< of each component, in bank_
  int since_ = 0;
};

}  // namespace

std::unique_ptr<Method> MakeLuenbergerBank(const MethodTask& task) {
  return std::make_unique<ObserverBank>(task, Injection::kLuenberger);
}
std::unique_ptr<Method> MakeKalmanBank(const MethodTask& task) {
  return std::make_unique<ObserverBank>(task, Injection::kKalman);
}
std::unique_ptr<Method> MakeSlidingModeBank(const MethodTask& task) {
  return std::make_unique<ObserverBank>(task, Injection::kSlidingMode);
}

}  // namespace faultlab::core
