#include "core/diagnosis/rig_watch.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/diagnosis/pipeline.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "hardware/bench/benches.h"

namespace faultlab::core {
namespace {

// A winding of ten times the resistance brings the motor to rest for two minutes. Its friction is
// not as modelled there, and so many times the noise is expected: that is not learnt as the rig's.
TEST(RigWatch, LearnsNoNoiseFromAMotorAtRest) {
  const Bench& bench = *hardware::LoadBench("speed-motor").value();
  PrbsSpec input;
  input.low_v = 0.15 * bench.limits.uc_v_max;
  input.high_v = 0.55 * bench.limits.uc_v_max;
  input.clock_s = 0.05;
  Fault winding;
  winding.at_s = 20.0;
  winding.component = *bench.Find("Ra");
  winding.value = 10.0 * bench.nominal.Get(*bench.Find("Ra"));
  Fault mended = winding;
  mended.at_s = 140.0;
  mended.value = bench.nominal.Get(*bench.Find("Ra"));
  const std::vector<Sample> samples =
      SimulateRecord(bench.profiles.front(),
                     bench.nominal,
                     MakePrbs(input, static_cast<int>(180.0 / bench.period_s), bench.period_s),
                     std::vector{winding, mended},
                     1,
                     bench.period_s);

  const DiagnosisOptions options = OptionsOf(bench);
  Pipeline pipeline(options);
  std::optional<RigWatch> watch;
  bool rested = false;
  for (const Sample& sample : samples) {
    const Frame& frame = pipeline.Push(sample);
    if (!watch) {
      while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
      if (pipeline.calibration()) watch.emplace(options, pipeline.calibration(), 1);
      continue;
    }
    watch->Push(sample);
    while (auto task = watch->TakeTask()) watch->Accept(Isolate(*task), frame);
    rested = rested || (sample.t_s > 130.0 && watch->verdict().kind == VerdictKind::kFault);
  }
  EXPECT_TRUE(rested);
  EXPECT_EQ(watch->verdict().kind, VerdictKind::kNominal);
  for (std::size_t channel = 0; channel < kOutputCount; ++channel) {
    EXPECT_NEAR(watch->noise_scale().Weight(channel), 1.0, 0.03) << channel;
  }
}

}  // namespace
}  // namespace faultlab::core
