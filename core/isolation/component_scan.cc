#include "core/isolation/component_scan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/isolation/profile_cost.h"
#include "core/numerics/golden_section.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Samples at 100 Hz (SpanOf): as long as the input may rest. While it rests, whatever is far off
// explains a motor that turns steadily.
constexpr std::size_t kScanSamples = 400;
constexpr int kSections = 12;

// For each component, the interval between the neighbours of the best point of the scan.
std::vector<GoldenSection> FindValleys(ProfileCost& quick,
                                       std::span<const Component> components,
                                       std::span<const Observation> stretch) {
  std::vector<ProfileCost::Point> points;
  for (Component component : components) {
    const ValueRange range = RangeOf(component);
    for (int i = 0; i < range.points; ++i) points.push_back({component, range.LogAt(i)});
  }
  const std::vector<ProfileCost::Result>& results = quick.At(points, stretch);
  std::vector<GoldenSection> valleys;
  std::size_t first = 0;
  for (Component component : components) {
    const ValueRange range = RangeOf(component);
    int best = 0;
    for (int i = 1; i < range.points; ++i) {
      const auto at = first + static_cast<std::size_t>(i);
      if (results[at].cost < results[first + static_cast<std::size_t>(best)].cost) best = i;
    }
    valleys.emplace_back(range.LogAt(std::max(0, best - 1)),
                         range.LogAt(std::min(range.points - 1, best + 1)));
    first += static_cast<std::size_t>(range.points);
  }
  return valleys;
}

}  // namespace

std::vector<HypothesisFit> ScanComponents(const FitContext& context,
                                          std::span<const Component> components) {
  const auto stretch = context.stretch.first(
      std::min(SpanOf(kScanSamples, context.period_s), context.stretch.size()));
  const std::size_t n = components.size();
  ProfileCost quick(context);
  std::vector<GoldenSection> sections = FindValleys(quick, components, stretch);
  std::vector<ProfileCost::Point> points;
  for (std::size_t i = 0; i < n; ++i) {
    points.push_back({components[i], sections[i].x1});
    points.push_back({components[i], sections[i].x2});
  }
  const std::vector<ProfileCost::Result>& inner = quick.At(points, stretch);
  for (std::size_t i = 0; i < n; ++i) {
    sections[i].f1 = inner[2 * i].cost;
    sections[i].f2 = inner[2 * i + 1].cost;
  }
  points.resize(n);
  std::vector<double*> costs(n);
  for (int round = 0; round < kSections; ++round) {
    for (std::size_t i = 0; i < n; ++i) {
      const GoldenSection::Open open = sections[i].Narrow();
      points[i] = {components[i], open.x};
      costs[i] = open.f;
    }
    const std::vector<ProfileCost::Result>& results = quick.At(points, stretch);
    for (std::size_t i = 0; i < n; ++i) *costs[i] = results[i].cost;
  }
  for (std::size_t i = 0; i < n; ++i) points[i] = {components[i], sections[i].best()};
  const std::vector<ProfileCost::Result>& results = quick.At(points, context.stretch);
  std::vector<HypothesisFit> fits(n);
  for (std::size_t i = 0; i < n; ++i) {
    HypothesisFit& h = fits[i];
    h.component = components[i];
    h.exists = true;
    h.value = std::exp(points[i].log_value);
    h.log_sigma = std::numeric_limits<double>::quiet_NaN();
    h.nuisance = context.calibration.mean;
    h.magnitude_cost = MagnitudePrior(context.rig.plant, h.component, h.value);
    h.cost = results[i].cost;
    h.chi2 = results[i].chi2;
    h.count = results[i].count;
  }
  return fits;
}

}  // namespace faultlab::core
