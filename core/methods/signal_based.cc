// Signal based diagnosis (paper section 1, [19, 22-25]): no model of the input. Over windows of N
// samples of the fitted channel, and of ia where it is read:
//   mean, log energy of the DFT in octaves of frequency, log energy of the Haar wavelet's levels
// Detection: sum of squared distances from the healthy windows, by their standard deviations.
// Isolation, identification: nearest of a library of simulated faulty rigs (each component, each
// value of its scan) under the input of the healthy stretch. Tuning: N, a power of two.
// Source: S. Mallat, IEEE Trans. PAMI 11 (1989); M. Benbouzid, IEEE Trans. Ind. Electron. 47
// (2000).
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "core/isolation/profile_cost.h"
#include "core/methods/hypotheses.h"
#include "core/methods/method_list.h"
#include "core/signals/random.h"

namespace faultlab::core {
namespace {

using Features = std::vector<double>;

double LogEnergy(double sum) {
  return std::log(sum + 1e-9);
}

void AddFeatures(const std::vector<double>& window, Features& out) {
  const std::size_t n = window.size();
  double mean = 0.0;
  for (const double y : window) mean += y / static_cast<double>(n);
  out.push_back(mean);
  // Octaves [2^b, 2^(b+1)) of the DFT's lines below half the rate.
  for (std::size_t from = 1; from < n / 2; from *= 2) {
    double energy = 0.0;
    for (std::size_t line = from; line < std::min(2 * from, n / 2); ++line) {
      const double turn =
          2.0 * std::numbers::pi * static_cast<double>(line) / static_cast<double>(n);
      const std::complex<double> step = std::polar(1.0, -turn);
      std::complex<double> phase = 1.0;
      std::complex<double> sum = 0.0;
      for (const double y : window) {
        sum += (y - mean) * phase;
        phase *= step;
      }
      energy += std::norm(sum);
    }
    out.push_back(LogEnergy(energy / static_cast<double>(n * n)));
  }
  std::vector<double> level = window;
  while (level.size() > 8) {
    std::vector<double> next(level.size() / 2);
    double energy = 0.0;
    for (std::size_t i = 0; i < next.size(); ++i) {
      next[i] = (level[2 * i] + level[2 * i + 1]) * std::numbers::sqrt2 / 2.0;
      const double detail = (level[2 * i] - level[2 * i + 1]) * std::numbers::sqrt2 / 2.0;
      energy += detail * detail;
    }
    out.push_back(LogEnergy(energy / static_cast<double>(n)));
    level = std::move(next);
  }
}

class SignalBased : public Method {
 public:
  explicit SignalBased(const MethodTask& task)
      : task_(task), size_(static_cast<std::size_t>(std::lround(task.tuning))) {
    const std::size_t hop = std::max<std::size_t>(1, size_ / 8);
    Features squares;
    double count = 0.0;
    for (const Observation& o : task.healthy) {
      if (!Take(o, hop)) continue;
      const Features now = FeaturesOfWindow();
      if (mean_.empty()) {
        mean_.assign(now.size(), 0.0);
        squares.assign(now.size(), 0.0);
      }
      count += 1.0;
      for (std::size_t i = 0; i < now.size(); ++i) {
        const double off = now[i] - mean_[i];
        mean_[i] += off / count;
        squares[i] += off * (now[i] - mean_[i]);
      }
    }
    constexpr double kFloor = 0.1;  // few windows overlap in a short stretch
    for (const double square : squares) sd_.push_back(std::sqrt(square / count) + kFloor);
    channels_.assign(channels_.size(), {});
  }

  void Push(const Sample&, const Observation& o) override {
    if (mean_.empty() || !Take(o, size_ / 4)) return;
    const Features now = FeaturesOfWindow();
    statistic_ = Distance(now, mean_);
    if (!alarmed_) return;
    if (since_.empty()) since_.assign(now.size(), 0.0);
    windows_ += 1.0;
    for (std::size_t i = 0; i < now.size(); ++i) since_[i] += (now[i] - since_[i]) / windows_;
  }
  double statistic() const override { return statistic_; }
  void OnAlarm() override {
    alarmed_ = true;
    for (std::vector<double>& channel : channels_) channel.clear();
  }
  MethodFinding Diagnose() override {
    MethodFinding finding;
    if (since_.empty()) return {Answer::kNotYet, Answer::kNotYet, {}, 0};
    for (const Component component : task_.bench->components()) {
      const ValueRange range = RangeOf(component);
      MethodCandidate best{component, 0.0, 1e300};
      for (int i = 0; i < range.points; ++i) {
        const double cost = Distance(since_, Simulated(ModelOf(task_, component, range.LogAt(i))));
        if (cost < best.cost) best = {component, std::exp(range.LogAt(i)), cost};
      }
      finding.candidates.push_back(best);
    }
    constexpr double kSame = 1e-6;
    FinishFinding(kSame, true, finding);
    return finding;
  }
  std::size_t bytes() const override {
    return sizeof *this + (channels_.size() * size_ + 3 * mean_.size()) * sizeof(double);
  }

 private:
  /// True every `hop` samples once the window is full.
  bool Take(const Observation& o, std::size_t hop) {
    std::vector<double> readings;
    if (task_.Has(o)) readings.push_back(task_.Reading(o));
    if (task_.channel() == 0 && ((o.mask >> 1) & 1U) != 0U) readings.push_back(o.y[1]);
    if (channels_.empty()) channels_.resize(readings.size());
    if (o.restart || readings.empty() || readings.size() != channels_.size()) {
      for (std::vector<double>& channel : channels_) channel.clear();
      return false;
    }
    for (std::size_t c = 0; c < readings.size(); ++c) {
      if (channels_[c].size() == size_) channels_[c].erase(channels_[c].begin());
      channels_[c].push_back(readings[c]);
    }
    ++count_;
    return channels_.front().size() == size_ && count_ % hop == 0;
  }
  Features FeaturesOfWindow() const {
    Features out;
    for (const std::vector<double>& channel : channels_) AddFeatures(channel, out);
    return out;
  }
  double Distance(const Features& a, const Features& b) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double off = (a[i] - b[i]) / sd_[i];
      sum += off * off;
    }
    return std::isfinite(sum) ? sum : 1e300;
  }
  Features Simulated(const PredictionModel& model) {
    Random random(task_.seed);
    std::vector<std::vector<double>> windows(channels_.size());
    Features mean;
    double count = 0.0;
    Eigen::Vector4d x = TurningState(model, task_.healthy.front().u_prev);
    for (const Observation& o : task_.healthy) {
      const Eigen::Vector4d moved = Step(model, x, model.Limited(o.u_prev), model.Limited(o.u));
      x = moved;
      for (std::size_t c = 0; c < windows.size(); ++c) {
        const int row = c == 0 ? task_.channel() : 1;
        const double noise = std::sqrt(model.reading_variance[static_cast<std::size_t>(row)]);
        windows[c].push_back(model.c.row(row).dot(x) + model.d(row) * model.Limited(o.u) +
                             noise * random.Normal());
      }
      if (windows.front().size() < size_) continue;
      Features now;
      for (const std::vector<double>& window : windows) AddFeatures(window, now);
      if (mean.empty()) mean.assign(now.size(), 0.0);
      count += 1.0;
      for (std::size_t i = 0; i < now.size(); ++i) mean[i] += (now[i] - mean[i]) / count;
      for (std::vector<double>& window : windows) window.clear();
    }
    return mean.empty() ? mean_ : mean;
  }

  MethodTask task_;
  std::size_t size_;
  std::vector<std::vector<double>> channels_;
  Features mean_;
  Features sd_;
  Features since_;  ///< mean of the windows after the alarm
  double windows_ = 0.0;
  std::size_t count_ = 0;
  double statistic_ = 0.0;
  bool alarmed_ = false;
};

}  // namespace

std::unique_ptr<Method> MakeSignalBased(const MethodTask& task) {
  return std::make_unique<SignalBased>(task);
}

}  // namespace faultlab::core
