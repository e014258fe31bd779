#include "tests/bench/study_alarms.h"

#include <cstdio>
#include <optional>
#include <vector>

#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "tests/bench/study_trial.h"
#include "tests/paper_rig.h"

namespace faultlab::study {

using namespace core;

AlarmCount CountFalseAlarms(const Settings& settings, bool um_only) {
  AlarmCount count;
  const int samples_per_rig =
      static_cast<int>(settings.rig_minutes * 60.0 * (1.0 / paper::kPeriodS));
  for (int run = 0; count.hours < settings.hours; ++run) {
    const std::uint64_t seed = StreamSeed(settings.seed, 1000 + static_cast<std::uint64_t>(run));
    Random random(StreamSeed(seed, 7));
    const PlantParameters rig = DrawRig(0.05, random);
    PrbsSpec prbs;
    prbs.order = 16;
    prbs.seed = 1 + random.Below(1000);
    const std::vector<double> uc_v = MakePrbs(prbs, samples_per_rig, paper::kPeriodS);
    const std::vector<Sample> samples =
        SimulateRecord(paper::Hardware(), rig, uc_v, {}, seed, paper::kPeriodS);
    DiagnosisOptions config = paper::Options();
    config.channels = um_only ? Channels::kUmOnly : Channels::kAll;
    Pipeline pipeline(config);
    std::optional<double> last;
    for (const Sample& sample : samples) {
      pipeline.Push(sample);
      SolveTasks(pipeline);
      const std::optional<double> detected = pipeline.verdict().detected_at_s;
      if (detected && detected != last) {
        ++count.alarms;
        last = detected;
        if (settings.verbose) {
          std::fprintf(stderr,
                       "false alarm%s: rig %d seed %llu t %.2f by %s: %s\n",
                       um_only ? " (um)" : "",
                       run,
                       static_cast<unsigned long long>(seed),
                       *detected,
                       pipeline.verdict().detector.c_str(),
                       Describe(pipeline.verdict()).c_str());
        }
      }
    }
    ++count.rigs;
    count.refused += pipeline.calibration() == nullptr;
    count.hours += settings.rig_minutes / 60.0;
  }
  return count;
}

}  // namespace faultlab::study
