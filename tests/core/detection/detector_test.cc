#include "core/detection/detector.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "core/calibration/calibrate.h"
#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

/// Time of the first alarm, of a rig that was learnt from another record.
std::optional<double> FirstAlarm(const std::vector<Sample>& record) {
  const auto healthy = Between(BenchRecord({}, 62, 8.0), 0.5, 8.0);
  const Calibration calibration = Calibrate(healthy, paper::ToCalibrate()).value();
  Detector detector(paper::Bench(),
                    ParametersOf(calibration),
                    NoiseOf(calibration),
                    0.01,
                    7U,
                    calibration.thresholds,
                    calibration.samples,
                    NoiseScale(calibration.samples));
  std::vector<double> t_s;
  const auto observations =
      MakeObservations(record, paper::Bench().readings(), Channels::kAll, 0.01, 10.0, {}, &t_s);
  for (std::size_t k = 0; k < observations.size(); ++k) {
    if (detector.Push(observations[k])) return t_s[k];
  }
  return std::nullopt;
}

TEST(Detector, KeepsQuietForAQuarterOfAnHourAndSeesAFaultAfterIt) {
  const auto record = BenchRecord({AbruptFault(paper::kRa, 6.0, 900.0)}, 61, 901.0);
  const std::optional<double> alarm_s = FirstAlarm(Between(record, 0.5, 901.0));
  ASSERT_TRUE(alarm_s.has_value());
  EXPECT_GE(*alarm_s, 900.0);
  EXPECT_LE(*alarm_s, 900.05);
}

// A network or a slow computer loses a sample now and then; what the others say adds up all the
// same.
TEST(Detector, SeesASmallFaultAlthoughSamplesAreLost) {
  const double small = 1.004 * paper::Plant().ra_ohm;
  auto record = BenchRecord({AbruptFault(paper::kRa, small, 300.0)}, 63, 320.0);
  const std::optional<double> whole_s = FirstAlarm(Between(record, 0.5, 320.0));
  ASSERT_TRUE(whole_s.has_value());
  EXPECT_GT(*whole_s, 301.0) << "else it is not small";
  std::erase_if(record, [](const Sample& sample) { return sample.index % 53 == 0; });
  const std::optional<double> lossy_s = FirstAlarm(Between(record, 0.5, 320.0));
  ASSERT_TRUE(lossy_s.has_value());
  EXPECT_GE(*lossy_s, 300.0) << "five minutes without a fault";
  EXPECT_LT(*lossy_s, *whole_s + 4.0);
}

}  // namespace
}  // namespace faultlab::core
