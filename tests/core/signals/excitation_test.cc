#include "core/signals/excitation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.01;
// Rounding error of some hundred cosines.
constexpr double kTolerance = 1e-9;

std::complex<double> Line(const std::vector<double>& x, int harmonic) {
  std::complex<double> sum;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double angle =
        -2.0 * std::numbers::pi * harmonic * static_cast<double>(k) / static_cast<double>(x.size());
    sum += x[k] * std::polar(1.0, angle);
  }
  return sum / static_cast<double>(x.size());
}

TEST(Step, FirstSampleAtOrAfterTheTimeIsHigh) {
  const std::vector<double> uc_v = MakeStep({.low_v = 1.0, .high_v = 4.0, .at_s = 0.3}, 100, 0.1);
  EXPECT_EQ(uc_v[2], 1.0);
  EXPECT_EQ(uc_v[3], 4.0);  // 3 * 0.1 is above 0.3 only by rounding
  EXPECT_EQ(MakeStep({.at_s = 0.0}, 2, 0.1)[0], 3.0);
}

TEST(Multisine, HasEqualPowerOnItsLinesAndNoneBetween) {
  const MultisineSpec spec;
  const std::vector<double> uc_v = MakeMultisine(spec, 200, kPeriodS);  // one base period
  const double power = std::norm(Line(uc_v, 1));
  EXPECT_GT(power, 0.0);
  for (int line = 1; line <= 99; ++line) {
    EXPECT_NEAR(std::norm(Line(uc_v, line)), line <= spec.lines ? power : 0.0, kTolerance) << line;
  }
  EXPECT_NEAR(Line(uc_v, 0).real(), spec.offset_v, kTolerance);
}

TEST(Multisine, SchroederPhasesKeepTheCrestFactorBelowTwo) {
  const std::vector<double> uc_v = MakeMultisine({.offset_v = 0.0, .seed = 0}, 200, kPeriodS);
  double power = 0.0;
  double peak = 0.0;
  for (const double value : uc_v) {
    power += value * value / 200.0;
    peak = std::max(peak, std::abs(value));
  }
  EXPECT_LE(peak, 0.5);
  EXPECT_GT(peak, 0.45);  // the amplitude is used
  EXPECT_LT(peak / std::sqrt(power), 2.0);
}

TEST(Chirp, BeginsAndEndsAtItsFrequencies) {
  // Zero crossings of a linear sweep: the phase is from t + (to - from) t^2 / 2D cycles.
  const ChirpSpec spec{.offset_v = 0.0, .amplitude_v = 1.0, .from_hz = 1.0, .to_hz = 5.0};
  const std::vector<double> uc_v = MakeChirp(spec, 20'000, 0.001);
  int crossings = 0;
  for (std::size_t k = 1; k < uc_v.size(); ++k) {
    crossings += (uc_v[k - 1] < 0.0) != (uc_v[k] < 0.0);
  }
  const double cycles = 0.5 * (1.0 + 5.0) * 20.0;
  EXPECT_NEAR(crossings, 2.0 * cycles, 1.0);
  EXPECT_NEAR(
      uc_v[250], std::sin(2.0 * std::numbers::pi * (0.25 + 0.5 * 4.0 / 20.0 * 0.0625)), kTolerance);
}

TEST(Generate, MakesAsManySamplesAsTheDurationHolds) {
  for (const ExcitationSpec& spec : {ExcitationSpec(PrbsSpec{}),
                                     ExcitationSpec(StepSpec{}),
                                     ExcitationSpec(MultisineSpec{}),
                                     ExcitationSpec(ChirpSpec{})}) {
    const Result<std::vector<double>> uc_v = Generate(spec, 20.0, kPeriodS);
    ASSERT_TRUE(uc_v.ok()) << Name(spec) << ": " << uc_v.error().message;
    EXPECT_EQ(uc_v.value().size(), 2000U) << Name(spec);
  }
}

TEST(Generate, AListKeepsItsOwnLength) {
  const Result<std::vector<double>> uc_v = Generate(SamplesSpec{{1.0, 2.0, 3.0}}, 20.0, kPeriodS);
  EXPECT_EQ(uc_v.value(), (std::vector<double>{1.0, 2.0, 3.0}));
}

TEST(Generate, EveryRefusalNamesItsField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto field =
      [](const ExcitationSpec& spec, double duration_s = 20.0, double period_s = kPeriodS) {
        return Generate(spec, duration_s, period_s).error().field;
      };
  EXPECT_EQ(field(PrbsSpec{}, 20.0, 0.0), "period_s");
  EXPECT_EQ(field(PrbsSpec{}, 20.0, nan), "period_s");
  EXPECT_EQ(field(PrbsSpec{}, 0.0), "duration_s");
  EXPECT_EQ(field(PrbsSpec{}, nan), "duration_s");
  EXPECT_EQ(field(PrbsSpec{}, 1e9), "duration_s");
  EXPECT_EQ(field(PrbsSpec{.order = 99}), "order");
  EXPECT_EQ(field(StepSpec{.at_s = 20.0}), "at_s");
  EXPECT_EQ(field(StepSpec{.at_s = nan}), "at_s");
  EXPECT_EQ(field(StepSpec{.high_v = nan}), "high_v");
  EXPECT_EQ(field(MultisineSpec{.lines = 0}), "lines");
  EXPECT_EQ(field(MultisineSpec{.lines = 101}), "lines");  // 50.5 Hz of 100 Hz sampling
  EXPECT_EQ(field(MultisineSpec{.amplitude_v = 0.0}), "amplitude_v");
  EXPECT_EQ(field(MultisineSpec{.base_period_s = 0.0}), "base_period_s");
  EXPECT_EQ(field(ChirpSpec{.from_hz = -1.0}), "from_hz");
  EXPECT_EQ(field(ChirpSpec{.to_hz = 51.0}), "to_hz");
  EXPECT_EQ(field(SamplesSpec{}), "uc_v");
  EXPECT_EQ(field(SamplesSpec{{1.0, nan}}), "uc_v/1");
}

}  // namespace
}  // namespace faultlab::core
