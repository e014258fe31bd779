#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"
#include "core/types/calibration.h"
#include "core/types/component.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// What every method is told before it starts: the same for all, so that they differ only in what
/// they do with it.
struct MethodTask {
  const Bench* bench = nullptr;      ///< never null
  Calibration calibration;           ///< of the healthy stretch
  std::vector<Observation> healthy;  ///< the stretch, for the methods that learn from it
  /// Readings that the rest of the record has. The methods of the literature use the channel that
  /// the structure's estimators fit; signal based ones also ia.
  Channels channels = Channels::kUmOnly;
  double period_s = 0.01;
  double tuning = 0.0;     ///< of this method, in the unit that MethodInfo::tuned says
  std::uint64_t seed = 1;  ///< of methods that draw numbers

  /// Place of the fitted channel in Observation::y.
  int channel() const { return InfoOf(bench->structure->estimated).row; }
  bool Has(const Observation& o) const {
    return ((o.mask >> channel()) & 1U) != 0U && o.clipped == 0;
  }
  double Reading(const Observation& o) const { return o.y[static_cast<std::size_t>(channel())]; }
  /// Standard deviation of one reading of the fitted channel (V, A or rad/s).
  double noise() const {
    const std::array<double, 3> noises = {
        calibration.um_noise_v,
        calibration.ia_noise_a,
        calibration.n_noise_rpm * RadPerSecondOfRpm(calibration.nominal.gear_ratio)};
    return noises[static_cast<std::size_t>(channel())];
  }
};

enum class Answer {
  kCannot,  ///< the method has no means for it
  kNotYet,  ///< it could, but not from what it has seen
  kGiven,
};

constexpr std::string_view Name(Answer answer) {
  switch (answer) {
    case Answer::kCannot:
      return "cannot";
    case Answer::kNotYet:
      return "not_yet";
    case Answer::kGiven:
      return "given";
  }
  return "?";
}

/// One component that the method considers.
struct MethodCandidate {
  Component component{};
  double value = 0.0;  ///< SI unit; NaN if the method cannot size it
  double cost = 0.0;   ///< how badly it explains the record; the unit is the method's own
};

/// What a method says after its alarm.
struct MethodFinding {
  Answer isolation = Answer::kCannot;
  Answer identification = Answer::kCannot;
  std::vector<MethodCandidate> candidates;  ///< best first
  std::size_t named = 0;                    ///< the first so many are its answer
};

/// A method of fault diagnosis. It sees the observations of one record in order, from the sample
/// after the healthy stretch.
class Method {
 public:
  virtual ~Method() = default;

  virtual void Push(const Sample& sample, const Observation& observation) = 0;
  /// How unlike the healthy rig the newest samples are; the caller compares it with a level.
  virtual double statistic() const = 0;
  /// The statistic has passed its level: isolation may begin.
  virtual void OnAlarm() {}
  virtual MethodFinding Diagnose() = 0;
  /// Of its state, without the code and without its copy of the task.
  virtual std::size_t bytes() const = 0;
};

/// CUSUM of the squares of residuals whose healthy variance is 1, variance 4 against 1:
///   g <- max(0, g + 3/8 z^2 - ln 2)
/// Source: E. S. Page, Biometrika 41 (1954).
struct SquareCusum {
  double g = 0.0;
  void Push(double z) {
    constexpr double kShare = 0.375;
    constexpr double kDrift = 0.6931471805599453;
    g = std::max(0.0, g + kShare * z * z - kDrift);
  }
};

/// Orders by cost and sets what is answered: components whose costs agree within `same`.
void FinishFinding(double same, bool sized, MethodFinding& finding);

}  // namespace faultlab::core
