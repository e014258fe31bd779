// One rig's online cost per sample: simulated plant, six estimators, detection bank; and how many
// rigs one core runs in real time at 100 Hz. Goals: pipeline <= 2 us a sample, >= 5 000 rigs.
// The peer in the same run is a simple method that computes less: batch QR of one SWA window per
// sample.
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <functional>
#include <optional>
#include <vector>

#include "core/diagnosis/pipeline.h"
#include "core/estimators/estimator_bank.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

constexpr int kSamples = 20'000;

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double NanosecondsPerSample(int repetitions, const std::function<void()>& run) {
  double best = 1e9;
  for (int i = 0; i < repetitions; ++i) {
    const double start = CpuSeconds();
    run();
    best = std::min(best, CpuSeconds() - start);
  }
  return best / kSamples * 1e9;
}

volatile double sink = 0.0;

double BatchQr(const std::vector<Sample>& samples) {
  constexpr int kWindow = 100;
  return NanosecondsPerSample(2, [&] {
    Eigen::Matrix<double, Eigen::Dynamic, 3> phi(kWindow, 3);
    Eigen::VectorXd y(kWindow);
    for (std::size_t k = kWindow; k < samples.size(); ++k) {
      for (int i = 0; i < kWindow; ++i) {
        const Sample& now = samples[k - static_cast<std::size_t>(i)];
        const Sample& before = samples[k - static_cast<std::size_t>(i) - 1];
        phi(i, 0) = now.uc_v;
        phi(i, 1) = before.uc_v;
        phi(i, 2) = -before.um_v;
        y(i) = now.um_v;
      }
      const Eigen::Vector3d theta = phi.householderQr().solve(y);
      sink = theta(0);
    }
  });
}

double PipelineCost(const std::vector<Sample>& samples, Channels channels) {
  DiagnosisOptions config = paper::Options();
  config.channels = channels;
  Pipeline learning(config);
  for (std::size_t k = 0; k < 600; ++k) {
    learning.Push(samples[k]);
    while (std::optional<DiagnosisTask> task = learning.TakeTask()) {
      learning.Accept(RunTask(*task));
    }
  }
  if (learning.calibration() == nullptr) {
    std::printf("  calibration was refused, figures below are without detection\n");
  } else {
    config.calibration = *learning.calibration();
  }
  return NanosecondsPerSample(5, [&] {
    Pipeline pipeline(config);
    for (const Sample& sample : samples) {
      sink = pipeline.Push(sample).estimates[0].theta[0];
    }
  });
}

void Main() {
  const std::vector<double> uc_v = MakePrbs(PrbsSpec{}, kSamples, paper::kPeriodS);
  const BenchProfile profile = paper::Hardware();
  std::vector<Sample> samples;
  const double plant = NanosecondsPerSample(
      5, [&] { samples = SimulateRecord(profile, paper::Plant(), uc_v, {}, 1, paper::kPeriodS); });
  const double bank = NanosecondsPerSample(5, [&] {
    EstimatorBank estimators;
    std::array<Estimate<3>, kEstimatorCount> out;
    for (const Sample& sample : samples) {
      estimators.Push(sample, out);
    }
    sink = out[0].theta[0];
  });
  const double um_only = PipelineCost(samples, Channels::kUmOnly);
  const double all = PipelineCost(samples, Channels::kAll);
  const double qr = BatchQr(samples);
  std::printf("per sample, one thread\n");
  std::printf("  simulated plant with noise and converters  %8.0f ns\n", plant);
  std::printf("  six estimators                             %8.0f ns\n", bank);
  std::printf("  pipeline, um only                          %8.0f ns\n", um_only);
  std::printf("  pipeline, um + ia + n                      %8.0f ns  goal 2000 ns\n", all);
  std::printf("  peer: QR of one window alone               %8.0f ns  x%.2f of the pipeline\n",
              qr,
              qr / all);
  const double rigs = 1e9 / (1.0 / paper::kPeriodS) / (plant + all);
  std::printf("rigs in real time on one core, plant included: %.0f  goal 5000\n", rigs);
}

}  // namespace
}  // namespace faultlab::core

int main() {
  faultlab::core::Main();
  return 0;
}
