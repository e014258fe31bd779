// A neural network (paper section 1, [6, 18, 41]), evaluated here and trained by
// tests/bench/train_network.cc on simulated runs of the paper's bench; the weights are versioned in
// network_weights.cc together with their recipe. Inputs and layers: neural_network.h.
// Detection: the largest output of a component minus the output of `healthy`, mean of the newest
// `tuning` windows. Isolation: the largest mean output of the windows that lie after the alarm.
// Identification: its value output. A rig of another bench: Fits() in method_list.h is false.
// Source: C. M. Bishop, Neural Networks for Pattern Recognition (1995), chapter 4; training: M.
// Riedmiller, H. Braun, ICNN (1993).
#include "core/methods/neural_network.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/methods/hypotheses.h"
#include "core/methods/method_list.h"

namespace faultlab::core {

NetworkWindow::NetworkWindow(const MethodTask& task) : task_(task) {
  Raw mean{EquationVector::Zero(), 0.0, 0.0};
  double count = 0.0;
  for (const Observation& o : task.healthy) {
    Push(o);
    if (rows_.size() < kWindow) continue;
    const Raw now = RawInputs();
    count += 1.0;
    mean.theta += (now.theta - mean.theta) / count;
    mean.log_error += (now.log_error - mean.log_error) / count;
    mean.log_spread += (now.log_spread - mean.log_spread) / count;
  }
  healthy_ = mean;
  Restart();
}

void NetworkWindow::Restart() {
  rows_.clear();
  at_ = 0;
  equation_.Restart();
}

void NetworkWindow::Push(const Observation& o) {
  if (o.restart || !task_.Has(o)) Restart();
  EquationRow row;
  if (!task_.Has(o) || !equation_.Push(o.u, task_.Reading(o), row)) return;
  if (rows_.size() < kWindow) {
    rows_.push_back(row);
    return;
  }
  rows_[at_] = row;
  at_ = (at_ + 1) % kWindow;
}

NetworkWindow::Raw NetworkWindow::RawInputs() const {
  NormalSums sums;
  double mean = 0.0;
  double square = 0.0;
  for (const EquationRow& row : rows_) {
    sums.Add(row);
    mean += row(kEquationParameters);
    square += row(kEquationParameters) * row(kEquationParameters);
  }
  const double n = sums.rows;
  Raw raw;
  raw.theta = sums.Solve();
  raw.log_error = 0.5 * std::log(sums.ErrorVariance(raw.theta) + 1e-8);
  raw.log_spread = 0.5 * std::log(std::max(square / n - mean * mean / (n * n), 0.0) + 1e-8);
  return raw;
}

std::optional<NetworkInputs> NetworkWindow::Inputs() const {
  if (rows_.size() < kWindow) return std::nullopt;
  const Raw now = RawInputs();
  constexpr double kGain = 20.0;  // a change of a twentieth is where asinh begins to compress
  NetworkInputs inputs{};
  for (int i = 0; i < kEquationParameters; ++i) {
    const double off = std::clamp(now.theta(i) - healthy_.theta(i), -10.0, 10.0);
    inputs[static_cast<std::size_t>(i)] = std::asinh(kGain * off) / 3.0;
  }
  inputs[4] = std::asinh(now.log_error - healthy_.log_error);
  inputs[5] = std::asinh(3.0 * (now.log_spread - healthy_.log_spread));
  for (double& input : inputs) {
    if (!std::isfinite(input)) input = 0.0;
  }
  return inputs;
}

std::vector<double> Evaluate(const Network& network, std::span<const double> inputs) {
  std::vector<double> x(inputs.begin(), inputs.end());
  std::size_t at = 0;
  for (std::size_t layer = 1; layer < network.layers.size(); ++layer) {
    std::vector<double> next;
    for (int i = 0; i < network.layers[layer]; ++i) {
      double sum = static_cast<double>(network.weights[at++]);
      for (const double value : x) sum += static_cast<double>(network.weights[at++]) * value;
      next.push_back(1.7159 * std::tanh(sum / 3.0));
    }
    x = std::move(next);
  }
  return x;
}

namespace {

class NeuralNetwork : public Method {
 public:
  explicit NeuralNetwork(const MethodTask& task)
      : task_(task), window_(task_), smooth_(static_cast<std::size_t>(task.tuning)) {
    for (const int place : TrainedNetwork().components) {
      components_.push_back(task.bench->component(place));
    }
  }

  void Push(const Sample&, const Observation& o) override {
    window_.Push(o);
    if (++count_ % kHop != 0) return;
    const std::optional<NetworkInputs> inputs = window_.Inputs();
    if (!inputs) return;
    const std::vector<double> outputs = Evaluate(TrainedNetwork(), *inputs);
    const double most = *std::max_element(outputs.begin() + 1, outputs.end() - 1);
    recent_.push_back(most - outputs.front());
    if (recent_.size() > smooth_) recent_.pop_front();
    double sum = 0.0;
    for (const double each : recent_) sum += each;
    if (recent_.size() == smooth_) statistic_ = sum / static_cast<double>(smooth_);
    if (!alarmed_) return;
    if (sums_.empty()) sums_.assign(outputs.size(), 0.0);
    for (std::size_t i = 0; i < outputs.size(); ++i) sums_[i] += outputs[i];
    windows_ += 1.0;
  }
  double statistic() const override { return statistic_; }
  void OnAlarm() override {
    alarmed_ = true;
    window_.Restart();
  }
  MethodFinding Diagnose() override {
    MethodFinding finding{Answer::kNotYet, Answer::kNotYet, {}, 0};
    if (sums_.empty()) return finding;
    const double log_ratio = kNetworkLogScale * sums_.back() / windows_;
    for (std::size_t i = 0; i < components_.size(); ++i) {
      finding.candidates.push_back({components_[i],
                                    std::exp(LogStart(task_, components_[i]) + log_ratio),
                                    -sums_[1 + i] / windows_});
    }
    FinishFinding(0.0, true, finding);
    return finding;
  }
  std::size_t bytes() const override {
    return sizeof *this + NetworkWindow::kWindow * sizeof(EquationRow) +
           TrainedNetwork().weights.size_bytes();
  }

 private:
  static constexpr int kHop = 10;  // samples between two evaluations

  MethodTask task_;
  NetworkWindow window_;
  std::size_t smooth_;
  std::vector<Component> components_;
  std::deque<double> recent_;
  std::vector<double> sums_;
  double windows_ = 0.0;
  int count_ = 0;
  double statistic_ = -1.0;
  bool alarmed_ = false;
};

}  // namespace

std::unique_ptr<Method> MakeNeuralNetwork(const MethodTask& task) {
  return std::make_unique<NeuralNetwork>(task);
}

}  // namespace faultlab::core
