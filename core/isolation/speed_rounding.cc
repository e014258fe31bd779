#include "core/isolation/speed_rounding.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

constexpr unsigned kSpeedBit = 4U;
// Samples that are taken to share a rounding error, at most.
constexpr double kSharedMax = 50.0;

// Mean variance of the rounding of the speeds that a rig would have under the inputs of a stretch.
double PredictedRounding(const PredictionModel& model,
                         double step_s,
                         std::span<const Observation> stretch) {
  Eigen::Vector4d x = TurningState(model, stretch.front().u);
  double sum = 0.0;
  for (const Observation& o : stretch) {
    x = Step(model, x, model.Limited(o.u_prev), model.Limited(o.u)).eval();
    sum += RoundingVariance(x(2), step_s);
  }
  return sum / static_cast<double>(stretch.size());
}

}  // namespace

double AddedRounding(const PredictionModel& healthy,
                     double step_s,
                     std::span<const Observation> stretch) {
  double variance = 0.0;
  double steps = 0.0;
  double changes = 0.0;
  double last = 0.0;
  int readings = 0;
  for (const Observation& o : stretch) {
    if ((o.mask & kSpeedBit) == 0U) continue;
    const double w = o.y[2];
    variance += RoundingVariance(w, step_s);
    steps += w * w * step_s;
    if (readings > 0) changes += std::abs(w - last);
    last = w;
    ++readings;
  }
  if (readings == 0) return 0.0;
  const double more = variance / readings - PredictedRounding(healthy, step_s, stretch);
  if (!(more > 0.0)) return 0.0;
  const double shared = steps < kSharedMax * changes ? steps / changes : kSharedMax;
  return std::max(1.0, shared) * more;
}

}  // namespace faultlab::core
