#include "core/detection/detector.h"

#include <gtest/gtest.h>

#include <optional>

#include "core/calibration/calibrate.h"
#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

TEST(Detector, KeepsQuietForAQuarterOfAnHourAndSeesAFaultAfterIt) {
  const auto record = BenchRecord({AbruptFault(paper::kRa, 6.0, 900.0)}, 61, 901.0);
  const auto healthy = Between(BenchRecord({}, 62, 8.0), 0.5, 8.0);
  const Result<Calibration> calibration = Calibrate(healthy, paper::ToCalibrate());
  ASSERT_TRUE(calibration.ok());
  Detector detector(paper::Bench(),
                    ParametersOf(calibration.value()),
                    NoiseOf(calibration.value()),
                    0.01,
                    7U,
                    calibration.value().thresholds,
                    calibration.value().samples,
                    NoiseScale(calibration.value().samples));
  const auto observations = MakeObservations(
      Between(record, 0.5, 901.0), paper::Bench().readings(), Channels::kAll, 0.01, 10.0);
  std::optional<std::size_t> first;
  for (std::size_t k = 0; k < observations.size() && !first; ++k) {
    if (detector.Push(observations[k])) first = k;
  }
  ASSERT_TRUE(first.has_value());
  EXPECT_GE(*first, 89950U);
  EXPECT_LE(*first, 89955U);
}

}  // namespace
}  // namespace faultlab::core
