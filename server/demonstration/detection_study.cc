#include "server/demonstration/detection_study.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/calibration/calibrate.h"
#include "core/detection/detection_thresholds.h"
#include "core/detection/detector.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/filter/observation.h"
#include "server/demonstration/demonstration.h"

namespace faultlab::server {
namespace {

/// A minute of a bench at 100 Hz, in which alarms can be counted, and some seconds of the fault.
constexpr std::size_t kWatched = 6000;
constexpr std::size_t kFaulty = 500;
constexpr int kBlock = 10;

/// The detection bank with the calibration of one rig; starts anew after an alarm when it is told.
class Watch {
 public:
  Watch(const core::Bench& bench,
        const core::Calibration& calibration,
        const core::DetectionThresholds& thresholds,
        unsigned mask)
      : bench_(bench),
        calibration_(calibration),
        thresholds_(thresholds),
        mask_(mask),
        noise_scale_(calibration.samples) {
    Start();
  }

  std::optional<core::Alarm> Push(core::Observation observation) {
    observation.restart = observation.restart || fresh_;
    fresh_ = false;
    const std::optional<core::Alarm> alarm = detector_->Push(observation);
    if (alarm) {
      level_ = alarm->statistic / alarm->threshold;
      return alarm;
    }
    const core::Detector::Statistics& now = detector_->statistics();
    level_ = std::max({now.residual / thresholds_.residual,
                       now.cusum / thresholds_.cusum,
                       now.glr_short / thresholds_.glr_short,
                       now.glr_long / thresholds_.glr_long,
                       now.glr_slow / thresholds_.glr_slow});
    return alarm;
  }

  /// Of the newest sample, see DetectionStudy::level.
  double level() const { return level_; }

  /// Some 0.5 ms.
  void Start() {
    if (detector_) noise_scale_ = detector_->noise_scale();
    detector_.emplace(bench_,
                      core::ParametersOf(calibration_),
                      core::DetectionNoiseOf(calibration_),
                      calibration_.period_s,
                      mask_,
                      thresholds_,
                      calibration_.samples,
                      noise_scale_);
    fresh_ = true;
  }

 private:
  const core::Bench& bench_;
  const core::Calibration& calibration_;
  core::DetectionThresholds thresholds_;
  unsigned mask_;
  core::NoiseScale noise_scale_;
  std::optional<core::Detector> detector_;
  bool fresh_ = true;
  double level_ = 0.0;
};

std::size_t SamplesIn(double seconds, double period_s) {
  return static_cast<std::size_t>(std::lround(seconds / period_s));
}

}  // namespace

core::Result<std::shared_ptr<const core::Calibration>> DetectionStudies::CalibrationOf(
    const core::Bench& bench, const std::vector<core::Sample>& samples) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = learnt_.find(bench.id);
    if (found != learnt_.end()) return found->second;
  }
  const core::DiagnosisOptions usual = core::OptionsOf(bench);
  core::CalibrationOptions options;
  options.bench = &bench;
  options.data_sheet = usual.nominal;
  options.period_s = bench.period_s;
  options.um_rail_v = usual.um_rail_v;
  const std::size_t from = SamplesIn(usual.healthy_from_s, bench.period_s);
  const std::size_t to = SamplesIn(usual.healthy_to_s, bench.period_s);
  TRY(auto learnt, core::Calibrate(std::span(samples).subspan(from, to - from), options));
  auto calibration = std::make_shared<const core::Calibration>(std::move(learnt));
  const std::lock_guard lock(mutex_);
  if (learnt_.size() >= kKeptMax) learnt_.clear();
  learnt_.emplace(bench.id, calibration);
  return calibration;
}

core::Result<DetectionStudy> DetectionStudies::Study(const core::Bench& bench,
                                                     const std::vector<core::Fault>& changes,
                                                     double false_alarms_per_day) {
  const core::DiagnosisOptions usual = core::OptionsOf(bench);
  const std::size_t learning = SamplesIn(usual.healthy_to_s, bench.period_s);
  TRY(const auto played, PlayDemonstration(bench, changes, {learning + kWatched, kFaulty}));
  const std::vector<core::Sample>& samples = played.samples;
  TRY(const auto calibration, CalibrationOf(bench, samples));
  const core::Calibration& learnt = *calibration;
  const unsigned mask = learnt.mask();
  Watch watch(
      bench, learnt, core::MakeThresholds(false_alarms_per_day, 1.0 / bench.period_s, mask), mask);
  core::ObservationBuilder builder(bench.readings(),
                                   core::Channels::kAll,
                                   bench.period_s,
                                   usual.um_rail_v,
                                   core::ErrorsOf(learnt));

  DetectionStudy study;
  study.block_samples = kBlock;
  study.watched_from_s = static_cast<double>(learning) * bench.period_s;
  const std::size_t fault_at = played.fault_at;
  study.fault_at_s = static_cast<double>(fault_at) * bench.period_s;
  for (std::size_t i = learning; i < samples.size(); ++i) {
    core::Observation observation;
    if (!builder.Push(samples[i], observation)) continue;
    const std::optional<core::Alarm> alarm = watch.Push(observation);
    if ((i - learning) % kBlock == 0) study.level.push_back(0.0);
    study.level.back() = std::max(study.level.back(), watch.level());
    if (!alarm) continue;
    if (i < fault_at) {
      study.false_alarms_s.push_back(samples[i].t_s);
      watch.Start();
    } else if (!study.delay_s) {
      study.delay_s = static_cast<double>(i - fault_at) * bench.period_s;
      study.detector = alarm->detector;
    }
  }
  return study;
}

}  // namespace faultlab::server
