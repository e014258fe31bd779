// Extended and unscented Kalman filters on state and parameters (paper section 1, [29, 34-37]); the
// filters are in parameter_filter.h. Two forms of each:
//   bank   one filter for each component, the others nominal. They start at the alarm with a wide
//          prior of the value; the smallest cost, sum of e^2/S + log S after the first samples, is
//          named.
//   joint  all distinct components in one filter, from the healthy stretch on; the parameter that
//          is furthest from nominal by its own standard deviation is named.
// Detection: CUSUM of the whitened innovations, bank: of the nominal filter.
// Tuning: standard deviation of the logarithm of a value at the alarm.
#include <cmath>
#include <memory>
#include <vector>

#include "core/methods/hypotheses.h"
#include "core/methods/method_list.h"
#include "core/methods/parameter_filter.h"
#include "core/methods/steady_filter.h"

namespace faultlab::core {
namespace {

constexpr double kWalk = 0.003;  // of a logarithm, per sample

// What is not known of the state right after a change: a lag that was not there, another speed.
Eigen::Matrix4d StateDoubt(const PredictionModel& model) {
  constexpr double kShare = 0.1;  // of the range in which a state can be
  Eigen::Vector4d sd;
  sd << kShare * model.start_sd, std::sqrt(model.torque_variance);
  return sd.cwiseAbs2().asDiagonal();
}

template <typename Filter>
class Bank : public Method {
 public:
  explicit Bank(const MethodTask& task)
      : task_(task), nominal_(SettledKalman(task, WatchedModel(task))) {
    for (const Observation& o : task.healthy) Watch(o);
    cusum_ = {};
  }

  void Push(const Sample&, const Observation& o) override {
    if (filters_.empty()) {
      Watch(o);
      return;
    }
    constexpr int kSettling = 5;  // samples in which the value is still far off
    ++since_;
    for (std::size_t i = 0; i < filters_.size(); ++i) {
      filters_[i].Push(o);
      if (!task_.Has(o) || since_ <= kSettling) continue;
      const double e = filters_[i].innovation();
      const double s = filters_[i].variance();
      costs_[i] += e * e / s + std::log(s);
    }
  }
  double statistic() const override { return cusum_.g; }
  void OnAlarm() override {
    for (const Component component : task_.bench->components()) {
      ParameterFilterSetup setup;
      setup.components = {component};
      // Where a value does not act, a filter has no slope to follow.
      setup.log_values = Eigen::VectorXd::Constant(1, LogVisible(task_, component));
      setup.log_sd = task_.tuning;
      setup.walk = kWalk;
      setup.x = nominal_.x;
      setup.p = StateDoubt(nominal_.model);
      filters_.emplace_back(task_, setup);
    }
    costs_.assign(filters_.size(), 0.0);
  }
  MethodFinding Diagnose() override {
    MethodFinding finding;
    for (std::size_t i = 0; i < filters_.size(); ++i) {
      finding.candidates.push_back(
          {filters_[i].components().front(), std::exp(filters_[i].LogValue(0)), costs_[i]});
    }
    constexpr double kSame = 1.0;  // of -2 log likelihood
    FinishFinding(kSame, true, finding);
    return finding;
  }
  std::size_t bytes() const override {
    std::size_t sum = sizeof *this + costs_.size() * sizeof(double);
    for (const Filter& filter : filters_) sum += filter.bytes();
    return sum;
  }

 private:
  void Watch(const Observation& o) {
    const double e = nominal_.Predict(task_, o);
    nominal_.x += nominal_.gain * e;
    if (task_.Has(o)) cusum_.Push(e * nominal_.inverse_sd);
  }

  MethodTask task_;
  SteadyFilter nominal_;
  SquareCusum cusum_;
  std::vector<Filter> filters_;
  std::vector<double> costs_;
  int since_ = 0;
};

template <typename Filter>
class Joint : public Method {
 public:
  explicit Joint(const MethodTask& task) : task_(task), filter_(task_, SetupOf(task_)) {
    for (std::size_t i = 0; i < filter_.components().size(); ++i) {
      start_.push_back(filter_.LogValue(i));
    }
    for (const Observation& o : task.healthy) Push({}, o);
    cusum_ = {};
  }

  void Push(const Sample&, const Observation& o) override {
    filter_.Push(o);
    if (task_.Has(o)) cusum_.Push(filter_.innovation() / std::sqrt(filter_.variance()));
  }
  double statistic() const override { return cusum_.g; }
  void OnAlarm() override {
    for (std::size_t i = 0; i < start_.size(); ++i) before_.push_back(filter_.LogValue(i));
    filter_.Doubt(task_.tuning);
  }
  MethodFinding Diagnose() override {
    MethodFinding finding;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      const auto at = 4 + static_cast<Eigen::Index>(i);
      const double sd = std::sqrt(std::max(filter_.p()(at, at), 1e-12));
      const double off = (filter_.LogValue(i) - before_[i]) / sd;
      finding.candidates.push_back(
          {filter_.components()[i], std::exp(filter_.LogValue(i)), -std::abs(off)});
    }
    FinishFinding(0.0, true, finding);
    return finding;
  }
  std::size_t bytes() const override {
    return sizeof *this + filter_.bytes() + 2 * start_.size() * sizeof(double);
  }

 private:
  static ParameterFilterSetup SetupOf(const MethodTask& task) {
    ParameterFilterSetup setup;
    setup.components = DistinctComponents(task);
    setup.log_values.resize(static_cast<Eigen::Index>(setup.components.size()));
    for (std::size_t i = 0; i < setup.components.size(); ++i) {
      setup.log_values(static_cast<Eigen::Index>(i)) = LogStart(task, setup.components[i]);
    }
    constexpr double kCalibrated = 0.02;  // what the stretch leaves unknown of a parameter
    constexpr double kSlow = 1e-4;
    setup.log_sd = kCalibrated;
    setup.walk = kSlow;
    const PredictionModel model = HealthyModel(task);
    if (!task.healthy.empty()) setup.x = TurningState(model, task.healthy.front().u_prev);
    setup.p = StateDoubt(model);
    return setup;
  }

  MethodTask task_;
  Filter filter_;
  std::vector<double> start_;
  std::vector<double> before_;
  SquareCusum cusum_;
};

}  // namespace

std::unique_ptr<Method> MakeEkfBank(const MethodTask& task) {
  return std::make_unique<Bank<ExtendedFilter>>(task);
}
std::unique_ptr<Method> MakeUkfBank(const MethodTask& task) {
  return std::make_unique<Bank<UnscentedFilter>>(task);
}
std::unique_ptr<Method> MakeEkfJoint(const MethodTask& task) {
  return std::make_unique<Joint<ExtendedFilter>>(task);
}
std::unique_ptr<Method> MakeUkfJoint(const MethodTask& task) {
  return std::make_unique<Joint<UnscentedFilter>>(task);
}

}  // namespace faultlab::core
