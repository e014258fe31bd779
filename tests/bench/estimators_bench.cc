// The cost of one update of an estimator, and of the paper's 216 000 estimates. Peers run in the
// same call: batch QR of every window (the paper's method), differences of cumulative sums (numpy's
// method, in C++), up- and down-dating with Eigen's LDLT, and numpy itself if it is installed. CPU
// time of the thread, best of the repetitions. Compare the ratios.
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/estimators/estimator_bank.h"
#include "core/estimators/instrumental_swa.h"
#include "core/estimators/sia.h"
#include "core/estimators/swa.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

constexpr int kWindow = 100;
constexpr int kIntegral = 20;

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Record {
  std::vector<double> u;
  std::vector<double> y;
};

Record MakeRecord(int samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.015);
  Record record;
  double state = 4.8;
  double before = 2.0;
  for (int k = 0; k < samples; ++k) {
    const double u = (random() >> 40) % 2 == 0 ? 2.0 : 3.0;
    state = 2.1146 * u - 1.0975 * before + 0.5751 * state;
    before = u;
    record.u.push_back(u);
    record.y.push_back(state + noise(random));
  }
  return record;
}

volatile double sink = 0.0;

/// Nanoseconds per sample, best of `repetitions`.
double Measure(int samples, int repetitions, const std::function<double()>& run) {
  double best = 1e9;
  for (int i = 0; i < repetitions; ++i) {
    const double start = CpuSeconds();
    sink = run();
    best = std::min(best, CpuSeconds() - start);
  }
  return best / samples * 1e9;
}

template <typename Estimator>
double Updates(Estimator estimator, const Record& record) {
  return Measure(static_cast<int>(record.u.size()), 200, [&] {
    double sum = 0.0;
    for (std::size_t k = 0; k < record.u.size(); ++k) {
      const auto& estimate = estimator.Push(record.u[k], record.y[k]);
      sum += estimate.theta[0] + estimate.condition;
    }
    return sum;
  });
}

using Phi = Eigen::Matrix<double, Eigen::Dynamic, 3>;

void FillRow(const Record& record, std::size_t k, Eigen::Index row, Phi& phi, Eigen::VectorXd& y) {
  phi(row, 0) = record.u[k];
  phi(row, 1) = record.u[k - 1];
  phi(row, 2) = -record.y[k - 1];
  y(row) = record.y[k];
}

/// The paper's method: QR of every window.
double BatchQr(const Record& record) {
  return Measure(static_cast<int>(record.u.size()), 3, [&] {
    Phi phi(kWindow, 3);
    Eigen::VectorXd y(kWindow);
    double sum = 0.0;
    for (std::size_t k = kWindow; k < record.u.size(); ++k) {
      for (int i = 0; i < kWindow; ++i) {
        FillRow(record, k - static_cast<std::size_t>(i), i, phi, y);
      }
      const Eigen::Vector3d theta = phi.householderQr().solve(y);
      sum += theta(0);
    }
    return sum;
  });
}

/// numpy's fastest method in C++: differences of cumulative sums, LDLT, no errors.
double CumulativeSums(const Record& record) {
  using Matrix4 = Eigen::Matrix4d;
  std::vector<Matrix4> sums(record.u.size(), Matrix4::Zero());
  return Measure(static_cast<int>(record.u.size()), 20, [&] {
    for (std::size_t k = 1; k < record.u.size(); ++k) {
      const Eigen::Vector4d row(record.u[k], record.u[k - 1], -record.y[k - 1], record.y[k]);
      sums[k].noalias() = sums[k - 1] + row * row.transpose();
    }
    double sum = 0.0;
    for (std::size_t k = kWindow; k < record.u.size(); ++k) {
      const Matrix4 normal = sums[k] - sums[k - kWindow];
      const Eigen::Matrix3d left = normal.topLeftCorner<3, 3>();
      const Eigen::Vector3d right = normal.topRightCorner<3, 1>();
      const Eigen::Vector3d theta = left.ldlt().solve(right);
      sum += theta(0);
    }
    return sum;
  });
}

/// Textbook sliding window: rank-one up and down, LDLT, no errors, no refresh.
double UpDownDating(const Record& record) {
  return Measure(static_cast<int>(record.u.size()), 20, [&] {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double sum = 0.0;
    for (std::size_t k = 1; k < record.u.size(); ++k) {
      const Eigen::Vector3d in(record.u[k], record.u[k - 1], -record.y[k - 1]);
      normal.noalias() += in * in.transpose();
      right += in * record.y[k];
      if (k <= kWindow) {
        continue;
      }
      const std::size_t j = k - kWindow;
      const Eigen::Vector3d out(record.u[j], record.u[j - 1], -record.y[j - 1]);
      normal.noalias() -= out * out.transpose();
      right -= out * record.y[j];
      const Eigen::Vector3d theta = normal.ldlt().solve(right);
      sum += theta(0);
    }
    return sum;
  });
}

/// -1 when there is no python3 with numpy.
double Numpy() {
  const std::string command =
      std::string("python3 ") + FAULTLAB_BENCH_PEERS + "/rolling_ls_numpy.py 2>/dev/null";
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) {
    return -1.0;
  }
  double ns = -1.0;
  if (std::fscanf(pipe, "%lf", &ns) != 1) {
    ns = -1.0;
  }
  pclose(pipe);
  return ns;
}

void PrintUpdates(const Record& record) {
  SwaOptions<1> swa;
  swa.window_samples = kWindow;
  SiaOptions<1> sia;
  sia.window_samples = kWindow;
  sia.integral_samples = kIntegral;
  SiaOptions<1> exact = sia;
  exact.mode = SiaMode::kExact;
  exact.delta_s = 0.0;
  SwaOptions<2> swa2;
  SiaOptions<2> sia2;
  SwaOptions<1, RowForm::kAffine> affine;
  const double own = Updates(Swa<1>(swa), record);
  std::printf("one update, window %d, theta + errors + sse + condition + status\n", kWindow);
  const auto line = [&](const char* name, double ns, const char* note) {
    std::printf("  %-38s %9.1f ns  x%-8.1f %s\n", name, ns, ns / own, note);
  };
  line("SWA order 1", own, "goal 25 ns");
  line("SIA order 1, paper", Updates(Sia<1>(sia), record), "goal 25 ns");
  line("SIA order 1, exact", Updates(Sia<1>(exact), record), "");
  line("SWA order 1, affine", Updates(Swa<1, RowForm::kAffine>(affine), record), "");
  line("SWA order 1, instruments", Updates(InstrumentalSwa(affine), record), "");
  line("SWA order 2", Updates(Swa<2>(swa2), record), "");
  line("SIA order 2", Updates(Sia<2>(sia2), record), "");
  line("peer: up/down-dating + Eigen LDLT", UpDownDating(record), "no errors, drifts");
  line("peer: cumulative sums + Eigen LDLT", CumulativeSums(record), "no errors, drifts");
  line("peer: Eigen QR of each window", BatchQr(record), "no errors");
  if (const double numpy = Numpy(); numpy > 0.0) {
    line("peer: numpy cumsum + batched solve", numpy, "no errors");
  } else {
    std::printf("  peer: numpy not installed, not run\n");
  }
}

void PrintWholePaper() {
  constexpr int kRecords = 18;
  constexpr int kSamples = 2000;
  std::vector<std::vector<Sample>> records;
  for (int r = 0; r < kRecords; ++r) {
    const Record record = MakeRecord(kSamples, static_cast<std::uint64_t>(r) + 10);
    std::vector<Sample>& samples = records.emplace_back();
    for (std::size_t k = 0; k < record.u.size(); ++k) {
      Sample& sample = samples.emplace_back();
      sample.index = static_cast<std::int64_t>(k);
      sample.t_s = paper::kPeriodS * static_cast<double>(k);
      sample.uc_v = record.u[k];
      sample.um_v = record.y[k];
    }
  }
  const auto run = [&](SiaMode mode) {
    return 1e-6 * Measure(1, 10, [&] {
             double sum = 0.0;
             for (const std::vector<Sample>& samples : records) {
               EstimatorBank bank({.sia_mode = mode, .delta_s = 0.0});
               std::array<Estimate<3>, kEstimatorCount> out;
               for (const Sample& sample : samples) {
                 bank.Push(sample, out);
                 sum += out[5].age_samples;
               }
             }
             return sum;
           });
  };
  const double paper_ms = run(SiaMode::kPaper);
  const double exact_ms = run(SiaMode::kExact);
  // The peer does the three SWA windows only; its QR costs the same for SIA's rows.
  const Record record = MakeRecord(kSamples, 10);
  const double qr_ms = 1e-6 * BatchQr(record) * kSamples * kRecords * kEstimatorCount;
  std::printf("216 000 estimates of the paper (18 records x 6 estimators x 2000 samples)\n");
  std::printf("  estimator bank, paper mode  %8.2f ms  goal 5 ms\n", paper_ms);
  std::printf("  estimator bank, exact mode  %8.2f ms\n", exact_ms);
  std::printf("  peer: Eigen QR, window 100  %8.2f ms  x%.0f\n", qr_ms, qr_ms / paper_ms);
}

}  // namespace
}  // namespace faultlab::core

int main() {
  const faultlab::core::Record record = faultlab::core::MakeRecord(20'000, 1);
  faultlab::core::PrintUpdates(record);
  faultlab::core::PrintWholePaper();
  return 0;
}
