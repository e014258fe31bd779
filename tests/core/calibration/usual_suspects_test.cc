// Records with what people's records have had wrong.
#include "core/calibration/usual_suspects.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/signals/prbs.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

constexpr double kRpm = 9.549296585513721;

std::string RefusalOf(std::vector<Sample> record, const std::function<void(Sample&)>& spoil) {
  for (Sample& sample : record) spoil(sample);
  const Result<Calibration> calibration = Calibrate(record, paper::ToCalibrate());
  return calibration.ok() ? "" : calibration.error().message;
}

std::vector<Sample> Healthy() {
  return Between(BenchRecord({}, 61, 6.0), 0.5, 6.0);
}

TEST(UsualSuspects, NameWhatMakesTheStretchFit) {
  const double gear = paper::kGearRatio;
  struct Spoilt {
    std::function<void(Sample&)> by;
    const char* said;
  };
  const Spoilt cases[] = {
      {[](Sample& s) { s.n_rpm /= kRpm; }, "n is multiplied by 9.549: is its unit rad/s?"},
      {[](Sample& s) { s.n_rpm *= 6.0; }, "is its unit deg/s?"},
      {[=](Sample& s) { s.n_rpm *= gear; },
       "n is multiplied by 0.2632: is it read on the other side"},
      {[=](Sample& s) { s.n_rpm *= gear / kRpm; },
       "is it in rad/s, on the other side of the gear?"},
      {[](Sample& s) { s.ia_a *= 1e3; }, "ia is multiplied by 0.001: is its unit mA?"},
      {[](Sample& s) { s.ia_a *= 1e-3; }, "ia is multiplied by 1000"},
      {[](Sample& s) { s.ia_a *= -1.0; }, "it fits with the other sign of ia"},
      {[](Sample& s) { s.n_rpm *= -1.0; }, "it fits with the other sign of n"},
      {[](Sample& s) { s.uc_v *= 1e3; }, "uc is multiplied by 0.001: is its unit mV?"},
  };
  for (const Spoilt& spoilt : cases) {
    const std::string refusal = RefusalOf(Healthy(), spoilt.by);
    EXPECT_NE(refusal.find(spoilt.said), std::string::npos)
        << spoilt.said << "\n  but: " << refusal;
  }
}

TEST(UsualSuspects, NameAChannelThatTheStretchFitsWithout) {
  const std::string refusal = RefusalOf(Healthy(), [](Sample& s) { s.n_rpm = 0.0; });
  EXPECT_NE(refusal.find("it fits without n: look at its wire"), std::string::npos) << refusal;
}

TEST(UsualSuspects, SayThatTheBeginningFits) {
  std::vector<Sample> record = Between(BenchRecord({}, 63, 40.0), 0.5, 40.0);
  const std::string refusal = RefusalOf(record, [](Sample& s) {
    if (s.t_s > 30.0) s.n_rpm = 0.0;
  });
  EXPECT_NE(refusal.find("its first 15 s fit: look for what"), std::string::npos) << refusal;
}

TEST(UsualSuspects, NameReadingsThatComeARowLate) {
  std::vector<Sample> record = Healthy();
  for (std::size_t k = record.size() - 1; k > 0; --k) {
    record[k].um_v = record[k - 1].um_v;
    record[k].ia_a = record[k - 1].ia_a;
    record[k].n_rpm = record[k - 1].n_rpm;
  }
  const std::string refusal = RefusalOf(record, [](Sample&) {});
  EXPECT_NE(refusal.find("moved one row up"), std::string::npos) << refusal;
}

TEST(UsualSuspects, AreNotBehindAFaultInsideTheStretch) {
  const auto record =
      Between(BenchRecord({AbruptFault(paper::kR12, 5.6e3, 3.0)}, 62, 6.0), 0.5, 6.0);
  const std::string refusal = RefusalOf(record, [](Sample&) {});
  EXPECT_NE(refusal, "");
  EXPECT_EQ(refusal.find("it fits"), std::string::npos) << refusal;
}

TEST(UsualSuspects, AreTriedOnBenchesWithoutAVoltage) {
  const Bench& bench = *hardware::LoadBench("gear-motor").value();
  const PrbsSpec spec{.low_v = 2.0, .high_v = 4.0, .clock_s = 0.05};
  std::vector<Sample> record = Between(SimulateRecord(bench.profiles.front(),
                                                      bench.nominal,
                                                      MakePrbs(spec, 1500, bench.period_s),
                                                      {},
                                                      63,
                                                      bench.period_s),
                                       0.5,
                                       15.0);
  for (Sample& sample : record) sample.n_rpm /= kRpm;
  CalibrationOptions options;
  options.bench = &bench;
  options.data_sheet = bench.nominal;
  options.period_s = bench.period_s;
  const Result<Calibration> calibration = Calibrate(record, options);
  ASSERT_FALSE(calibration.ok());
  EXPECT_NE(calibration.error().message.find("is its unit rad/s?"), std::string::npos)
      << calibration.error().message;
}

}  // namespace
}  // namespace faultlab::core
