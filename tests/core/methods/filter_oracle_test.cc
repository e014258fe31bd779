// EKF, UKF and RLS against an independent implementation in Python (filter_oracle.py) on one
// record.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "core/methods/method_session.h"
#include "core/methods/parameter_filter.h"
#include "core/methods/recursive_least_squares.h"
#include "tests/core/bench_records.h"
#include "tests/support/paths.h"

namespace faultlab::core {
namespace {

constexpr double kFault_ohm = 14.8;
constexpr double kWalk = 0.003;
constexpr double kLogSd = 0.3;
constexpr double kForget = 0.98;
constexpr double kRlsDoubt = 10.0;
const Eigen::Vector4d kStartVariance(1e-2, 1e-4, 25.0, 4e-10);

/// The numbers of the list `name` in the oracle's answer, nested lists flattened.
std::vector<double> NumbersOf(const std::string& json, const std::string& name) {
  std::vector<double> numbers;
  std::size_t at = json.find('"' + name + '"');
  if (at == std::string::npos) return numbers;
  at = json.find('[', at);
  int depth = 0;
  for (; at < json.size(); ++at) {
    if (json[at] == '[') ++depth;
    if (json[at] == ']' && --depth == 0) break;
    if (std::isdigit(json[at]) == 0 && json[at] != '-') continue;
    char* end = nullptr;
    numbers.push_back(std::strtod(json.c_str() + at, &end));
    at = static_cast<std::size_t>(end - json.c_str()) - 1;
  }
  return numbers;
}

class FilterOracle : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const std::vector<Sample> record =
        BenchRecord({AbruptFault(paper::kRa, kFault_ohm, 6.0)}, 5, 9);
    task_ = new MethodTask(
        PrepareMethods(record, MethodOptionsOf(paper::Bench(), paper::kPeriodS)).value());
    observations_ = new std::vector<Observation>(MakeObservations(Between(record, 5.0, 9.0),
                                                                  paper::Bench().readings(),
                                                                  Channels::kUmOnly,
                                                                  paper::kPeriodS,
                                                                  10.0));
    answer_ = new std::string(Ask());
  }
  static void TearDownTestSuite() {
    delete task_;
    delete observations_;
    delete answer_;
  }

  static ParameterFilterSetup StartSetup() {
    ParameterFilterSetup setup;
    setup.components = {paper::kRa};
    setup.log_values = Eigen::VectorXd::Constant(1, std::log(task_->calibration.nominal.ra_ohm));
    setup.log_sd = kLogSd;
    setup.walk = kWalk;
    setup.x = Eigen::Vector4d(2.5, 0.05, 230.0, 0.0);
    setup.p = kStartVariance.asDiagonal();
    return setup;
  }

  /// Log value of Ra after every 50th sample.
  template <typename Filter>
  static std::vector<double> Estimates() {
    Filter filter(*task_, StartSetup());
    std::vector<double> estimates;
    for (std::size_t n = 0; n < observations_->size(); ++n) {
      filter.Push((*observations_)[n]);
      if (n % 50 == 49) estimates.push_back(filter.LogValue(0));
    }
    return estimates;
  }

  static void ExpectAgreement(const std::vector<double>& ours, const char* name, double tolerance) {
    const std::vector<double> theirs = NumbersOf(*answer_, name);
    ASSERT_EQ(ours.size(), theirs.size()) << *answer_;
    ASSERT_GE(ours.size(), 8U);
    for (std::size_t i = 0; i < ours.size(); ++i) {
      EXPECT_NEAR(ours[i], theirs[i], tolerance) << name << " " << i;
    }
  }

  static MethodTask* task_;
  static std::vector<Observation>* observations_;
  static std::string* answer_;

 private:
  static std::string Ask() {
    const Calibration& c = task_->calibration;
    const PlantParameters& plant = c.nominal;
    const AmplifierResponse response = plant.response();
    const ParameterFilterSetup setup = StartSetup();
    constexpr double kShortestLag_s = 2e-5;  // of the prediction model
    std::ostringstream json;
    json.precision(17);
    json << "{\"rig\": {\"k\": " << c.gain_factor * response.gain
         << ", \"direct\": " << response.direct
         << ", \"lag\": " << std::max(kShortestLag_s, c.lag_factor * response.lag_s)
         << ", \"r1\": " << plant.series_ohm << ", \"la\": " << plant.la_henry
         << ", \"ke\": " << plant.ke_v_per_rad_s << ", \"kt\": " << plant.kt_nm_per_a
         << ", \"j\": " << plant.j_kg_m2 << ", \"b\": " << plant.b_nm_per_rad_s
         << ", \"tau\": " << c.friction_tau_s << ", \"mc\": " << c.mc_nm
         << ", \"creep\": " << plant.range.creep_rad_s << ", \"period\": " << c.period_s
         << ", \"delta\": " << c.delta_s << ", \"friction\": " << c.friction_noise_nm
         << ", \"um_noise\": " << c.um_noise_v << ", \"walk\": " << kWalk << "}, \"x\": ["
         << setup.x(0) << ", " << setup.x(1) << ", " << setup.x(2) << ", " << setup.x(3) << ", "
         << setup.log_values(0) << "], \"p\": [" << kStartVariance(0) << ", " << kStartVariance(1)
         << ", " << kStartVariance(2) << ", " << kStartVariance(3) << ", " << kLogSd * kLogSd
         << "], \"rls\": {\"theta\": [2.1, -1.1, -0.57, 0], \"p\": " << kRlsDoubt
         << ", \"forget\": " << kForget << "}, \"record\": [";
    for (std::size_t n = 0; n < observations_->size(); ++n) {
      const Observation& o = (*observations_)[n];
      if (n > 0) json << ',';
      json << '[' << o.u_prev << ", " << o.u << ", " << o.y[0] << "]";
    }
    json << "]}";
    const std::string path = testing::TempDir() + "filter_oracle.json";
    std::ofstream(path) << json.str();
    const std::string command = "/usr/bin/python3 '" +
                                tests::InSource("tests/core/methods/filter_oracle.py") + "' '" +
                                path + "'";
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
    std::string answer;
    std::array<char, 4096> part;
    while (pipe && std::fgets(part.data(), part.size(), pipe.get()) != nullptr)
      answer += part.data();
    return answer;
  }
};

MethodTask* FilterOracle::task_ = nullptr;
std::vector<Observation>* FilterOracle::observations_ = nullptr;
std::string* FilterOracle::answer_ = nullptr;

TEST_F(FilterOracle, ExtendedFilterAgreesToSixDigits) {
  const std::vector<double> ours = Estimates<ExtendedFilter>();
  ExpectAgreement(ours, "ekf", 1e-6);  // eigenvalues against scaling and squaring
  EXPECT_NEAR(ours.back(), std::log(kFault_ohm), 0.1) << "it has followed the fault";
}

TEST_F(FilterOracle, UnscentedFilterAgreesToThreeDigits) {
  const std::vector<double> ours = Estimates<UnscentedFilter>();
  ExpectAgreement(ours, "ukf", 1e-3);  // another square root of P: other sigma points
  EXPECT_NEAR(ours.back(), std::log(kFault_ohm), 0.1);
}

TEST_F(FilterOracle, RecursiveLeastSquaresAgreesToEightDigits) {
  DiscreteEquation equation;
  RecursiveLeastSquares rls(
      EquationVector(2.1, -1.1, -0.57, 0.0), kRlsDoubt * EquationMatrix::Identity(), kForget);
  std::vector<double> ours;
  EquationRow row;
  for (std::size_t n = 0; n < observations_->size(); ++n) {
    if (equation.Push((*observations_)[n].u, (*observations_)[n].y[0], row)) rls.Push(row);
    if (n % 50 != 49) continue;
    for (int i = 0; i < kEquationParameters; ++i) ours.push_back(rls.theta()(i));
  }
  ExpectAgreement(ours, "rls", 1e-8);
}

}  // namespace
}  // namespace faultlab::core
