// Alarm levels of the detection bank, by simulation: the constants of
// core/detection/detection_thresholds.cc.
//   alarm_levels [--hours 168] [--seed 2]
// A healthy rig whose parameters and noise are known exactly is simulated by the prediction model
// itself (state, friction and readings drawn from their own covariances) under PRBS of 10 ms.
// Crossings of each statistic are counted at a grid of levels; a crossing within a second of the
// previous one belongs to it. The tail is exponential, so
//   level = at_day + per_decade * log10(crossings per 24 h)
// is fitted where crossings are neither crowded (kRateMax) nor few (kCountMin), each level weighted
// by its count. Deterministic for a seed. Takes some 70 s of CPU time for the 168 hours (a week).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "core/bench/profile.h"
#include "core/detection/detector.h"
#include "core/signals/prbs.h"
#include "core/signals/random.h"
#include "tests/paper_rig.h"

namespace faultlab::study {
namespace {

using namespace core;

constexpr int kStatistics = 5;
constexpr std::array<const char*, kStatistics> kNames = {
    "residual^2", "cusum", "glr_short", "glr_long", "glr_slow"};
constexpr double kGridStep = 0.5;
constexpr int kGrid = 100;
constexpr int kApart = 100;
constexpr double kRateMax = 1000.0;  // a day
constexpr int kCountMin = 8;
constexpr double kSamplesPerDay = 24.0 * 3600.0 * (1.0 / paper::kPeriodS);
constexpr int kWarmUp = 2000;
constexpr int kRecord = 360'000;

/// Upcrossings of a grid of levels by one statistic.
class Crossings {
 public:
  Crossings() { last_.fill(-kApart); }

  void Push(long sample, double value) {
    const int reached = std::min(kGrid - 1, static_cast<int>(value / kGridStep));
    for (int level = 0; level <= reached; ++level) {
      const auto l = static_cast<std::size_t>(level);
      if (sample - last_[l] >= kApart) ++count_[l];
      last_[l] = sample;
    }
  }

  /// at_day and per_decade.
  std::array<double, 2> Fit(double days) const {
    double weight = 0.0;
    double mean_x = 0.0;
    double mean_y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    // From above, because at low levels the signal crosses once and stays above.
    std::size_t lowest = kGrid;
    while (lowest > 1 && count_[lowest - 1] / days <= kRateMax) --lowest;
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t l = lowest; l < kGrid; ++l) {
        if (count_[l] < kCountMin) continue;
        const double w = count_[l];
        const double x = std::log10(count_[l] / days);
        const double y = kGridStep * static_cast<double>(l);
        if (pass == 0) {
          weight += w;
          mean_x += w * x;
          mean_y += w * y;
        } else {
          xx += w * (x - mean_x) * (x - mean_x);
          xy += w * (x - mean_x) * (y - mean_y);
        }
      }
      if (pass == 0) {
        mean_x /= weight;
        mean_y /= weight;
      }
    }
    const double per_decade = xy / xx;
    return {mean_y - per_decade * mean_x, per_decade};
  }

 private:
  std::array<long, kGrid> last_{};
  std::array<int, kGrid> count_{};
};

/// Readings of the prediction model under its own noise.
class ModelRecord {
 public:
  ModelRecord(const PredictionModel& model, unsigned mask, std::uint64_t seed)
      : model_(model), mask_(mask), random_(seed) {}

  Observation Next(double u) {
    Observation o;
    o.restart = first_;
    o.u = u;
    o.u_prev = first_ ? u : last_u_;
    const double sign = std::clamp(x_(2) / model_.creep_rad_s, -1.0, 1.0);
    const Eigen::Vector4d next = model_.phi * x_ + model_.g_prev * o.u_prev + model_.g * u +
                                 model_.g_torque * (sign * model_.mc_nm);
    x_ = next;
    x_(3) += std::sqrt(model_.torque_step_variance) * random_.Normal();
    o.mask = static_cast<std::uint8_t>(mask_);
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      const auto row = static_cast<Eigen::Index>(c);
      o.y[c] = model_.c.row(row).dot(x_) + model_.d(row) * u +
               std::sqrt(model_.reading_variance[c]) * random_.Normal();
    }
    first_ = false;
    last_u_ = u;
    return o;
  }

 private:
  const PredictionModel& model_;
  unsigned mask_;
  Random random_;
  Eigen::Vector4d x_ = Eigen::Vector4d::Zero();
  double last_u_ = 0.0;
  bool first_ = true;
};

void PrintLevels(double hours, unsigned mask, std::uint64_t seed) {
  const BenchProfile bench = paper::Hardware();
  RigParameters rig = paper::Rig();
  rig.delta_s = bench.delta_s;
  rig.mc_nm = bench.friction.mc_nm;
  NoiseLevel noise = paper::Noise();
  noise.w_rad_s = bench.noise.n_rpm * paper::kRadPerSecondOfRpm;
  constexpr int kKnownExactly = 1'000'000'000;
  constexpr double kNever = 1e300;
  const DetectionThresholds never{1.0, kNever, kNever, kNever, kNever, kNever};
  const PredictionModel model = MakePredictionModel(rig, noise, paper::kPeriodS);
  std::array<Crossings, kStatistics> crossings;
  long judged = 0;
  const int records = std::max(1, static_cast<int>(std::lround(hours)));
  for (int r = 0; r < records; ++r) {
    const std::uint64_t record_seed = StreamSeed(seed, static_cast<std::uint64_t>(r));
    PrbsSpec prbs;
    prbs.order = 16;
    prbs.seed = 1 + static_cast<std::uint32_t>(r);
    const std::vector<double> uc_v = MakePrbs(prbs, kRecord, paper::kPeriodS);
    ModelRecord record(model, mask, record_seed);
    Detector detector(paper::Bench(),
                      rig,
                      noise,
                      paper::kPeriodS,
                      mask,
                      never,
                      kKnownExactly,
                      NoiseScale(kKnownExactly));
    for (int k = 0; k < kRecord; ++k) {
      detector.Push(record.Next(uc_v[static_cast<std::size_t>(k)]));
      if (k < kWarmUp) continue;
      const Detector::Statistics& s = detector.statistics();
      const std::array<double, kStatistics> value = {
          s.residual * s.residual, s.cusum, s.glr_short, s.glr_long, s.glr_slow};
      for (std::size_t i = 0; i < kStatistics; ++i) {
        crossings[i].Push(static_cast<long>(r) * kRecord + k, value[i]);
      }
      ++judged;
    }
  }
  const double days = static_cast<double>(judged) / kSamplesPerDay;
  std::printf("%s, %.1f h: {at_day, per_decade}\n", mask == 1U ? "um" : "um+ia+n", days * 24.0);
  for (std::size_t i = 0; i < kStatistics; ++i) {
    const std::array<double, 2> fit = crossings[i].Fit(days);
    std::printf("  %-10s {%.1f, %.1f}\n", kNames[i], fit[0], fit[1]);
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace faultlab::study

int main(int argc, char** argv) {
  double hours = 168.0;
  std::uint64_t seed = 2;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--hours") == 0 && i + 1 < argc) {
      hours = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--seed") == 0 && i + 1 < argc) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else {
      std::fprintf(stderr, "usage: alarm_levels [--hours H] [--seed S]\n");
      return 2;
    }
  }
  faultlab::study::PrintLevels(hours, 1U, seed);
  faultlab::study::PrintLevels(hours, 7U, seed);
  return 0;
}
