#include "core/calibration/reading_steps.h"
#include "core/types/number_text.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace faultlab::core {
namespace {

// Noise of a channel whose readings are rounded is at least 0.29 of the step.
constexpr double kStepsOfNoise = 2.0;
// How far from a whole number of steps two readings may be apart: digits that a file has left out.
constexpr double kRounding = 0.02;
// Fewer different readings than these tell no step.
constexpr std::size_t kLevelsMin = 4;

}  // namespace

double StepOf(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double same = 1e-9 * (values.back() - values.front());
  std::vector<double> ways;  // from each level to the next
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (values[k] - values[k - 1] > same) ways.push_back(values[k] - values[k - 1]);
  }
  if (ways.size() + 1 < kLevelsMin) return 0.0;
  const double step = *std::min_element(ways.begin(), ways.end());
  const bool whole = std::all_of(ways.begin(), ways.end(), [&](double way) {
    return std::abs(way / step - std::round(way / step)) < kRounding;
  });
  return whole ? step : 0.0;
}

void SaySteps(std::span<const Sample> samples, Calibration& calibration) {
  struct Channel {
    const char* name;
    const char* unit;
    double Sample::*reading;
    bool used;
    double noise;
  };
  const std::array<Channel, 3> channels = {
      {{"um", "V", &Sample::um_v, calibration.used_um, calibration.um_noise_v},
       {"ia", "A", &Sample::ia_a, calibration.used_ia, calibration.ia_noise_a},
       {"n", "rpm", &Sample::n_rpm, calibration.used_n, calibration.n_noise_rpm}}};
  std::vector<double> values;
  for (const Channel& channel : channels) {
    if (!channel.used) continue;
    values.clear();
    for (const Sample& sample : samples) {
      if (std::isfinite(sample.*channel.reading)) values.push_back(sample.*channel.reading);
    }
    const double step = StepOf(values);
    const double limit = kStepsOfNoise * channel.noise;
    if (step <= limit) continue;
    const std::string text =
        Format("%s comes in steps of %.3g %s: what changes it by less is seen late, or not",
               channel.name,
               step,
               channel.unit);
    calibration.checks.push_back(
        {std::string("steps of ") + channel.name, text, step, limit, true});
  }
}

}  // namespace faultlab::core
