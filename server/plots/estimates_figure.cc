#include <algorithm>
#include <cmath>

#include "server/plots/figure_parts.h"
#include "server/plots/figures.h"
#include "server/plots/ticks.h"

namespace faultlab::server {
namespace {

constexpr int kFamilySize = 3;
constexpr int kB0 = 0;
constexpr int kB1 = 1;
constexpr int kA1 = 2;

struct FamilyNames {
  const char* title;
  const char* parameters[kFamilySize];
  const char* unit_b0;
  const char* unit_slow;  // of b1 and a1
  int first;              // index of its first estimator
};

constexpr FamilyNames kSwaNames = {"Estimates of the sliding window algorithm (SWA)",
                                   {"b_{0d}", "b_{1d}", "a_{1d}"},
                                   "V/V",
                                   "",
                                   static_cast<int>(core::EstimatorId::kSwa50)};
constexpr FamilyNames kSiaNames = {"Estimates of the sliding integral algorithm (SIA)",
                                   {"b_{0}", "b_{1}", "a_{1}"},
                                   "V/V",
                                   "s",
                                   static_cast<int>(core::EstimatorId::kSia20x5)};

std::string WindowName(const core::EstimatorShape& shape) {
  return shape.integral_samples == 0 ? "K = " + std::to_string(shape.window_samples)
                                     : "(K, m) = (" + std::to_string(shape.window_samples) + ", " +
                                           std::to_string(shape.integral_samples) + ")";
}

/// Samples after a change until the whole window lies behind it.
int SettlingSamples(const core::EstimatorShape& shape) {
  return shape.window_samples + shape.integral_samples - 1;
}

/// Computed from this very sample, with a known error. b1 and a1 come from one pole: when that is
/// only bounded (sigma infinite), neither is a point to draw.
bool IsUsable(const core::Estimate<3>& estimate, int parameter) {
  const bool computed = estimate.status == core::EstimateStatus::kExcited ||
                        estimate.status == core::EstimateStatus::kWeak;
  return computed && estimate.age_samples == 0 &&
         (parameter == kB0 ? std::isfinite(estimate.sigma[kB0])
                           : std::isfinite(estimate.sigma[kB1] + estimate.sigma[kA1]));
}

Series MakeEstimateSeries(
    std::span<const core::Frame> frames, int estimator, int parameter, Ink ink, Dash dash) {
  Series series;
  series.ink = ink;
  series.dash = dash;
  series.x.reserve(frames.size());
  series.y.reserve(frames.size());
  for (const core::Frame& frame : frames) {
    const core::Estimate<3>& estimate = frame.estimates[static_cast<std::size_t>(estimator)];
    series.x.push_back(frame.sample.t_s);
    series.y.push_back(IsUsable(estimate, parameter)
                           ? estimate.theta[static_cast<std::size_t>(parameter)]
                           : core::kAbsent);
  }
  return series;
}

/// Range of the bulk of the values: a short window may throw single estimates far away, and the
/// start-up does; both would press everything else flat.
std::optional<std::pair<double, double>> BulkRange(const Panel& panel) {
  constexpr double kTail = 0.01;
  constexpr double kMargin = 0.12;
  double low = 0.0;
  double high = 0.0;
  bool any = false;
  const auto take = [&](double from, double to) {
    low = any ? std::min(low, from) : from;
    high = any ? std::max(high, to) : to;
    any = true;
  };
  for (const Series& series : panel.series) {
    std::vector<double> values;
    std::copy_if(series.y.begin(), series.y.end(), std::back_inserter(values), [](double value) {
      return std::isfinite(value);
    });
    if (values.empty()) {
      continue;
    }
    const auto at = [&](double share) {
      const auto place = values.begin() + static_cast<std::ptrdiff_t>(
                                              share * static_cast<double>(values.size() - 1));
      std::nth_element(values.begin(), place, values.end());
      return *place;
    };
    take(at(kTail), at(1.0 - kTail));
  }
  for (const Level& level : panel.levels) {
    take(level.y, level.y);
  }
  if (!any) {
    return std::nullopt;
  }
  const double room = kMargin * (high - low);
  return room > 0.0 ? std::pair(low - room, high + room) : WithMargin(low, high);
}

void AddSettlingBands(Panel& panel, double change_s, double period_s, int first, bool named) {
  for (int i = 0; i < kFamilySize; ++i) {
    const core::EstimatorShape& shape = core::kEstimatorShapes[static_cast<std::size_t>(first + i)];
    Band band;
    band.x_from = change_s;
    band.x_to = change_s + SettlingSamples(shape) * period_s;
    if (named && i == 0) {
      band.name = "windows settling";
    }
    panel.bands.push_back(band);
  }
}

}  // namespace

Figure MakeEstimatesFigure(std::span<const core::Frame> frames,
                           EstimatorFamily family,
                           const FigureContext& context) {
  constexpr Ink kInks[] = {Ink::kBlue, Ink::kVermilion, Ink::kGreen};
  const bool swa = family == EstimatorFamily::kSwa;
  const FamilyNames& names = swa ? kSwaNames : kSiaNames;
  const std::optional<std::array<double, 3>>& nominal =
      swa ? context.nominal_swa : context.nominal_sia;
  Figure figure = MakeFigureOf(names.title, context);

  if (frames.size() > 1) {
    figure.x.range = WholeTime(frames.front().sample, frames.back().sample);
  }
  Panel upper;
  upper.y = {names.parameters[kB0], names.unit_b0, std::nullopt};
  Panel lower;
  lower.y = {std::string(names.parameters[kB1]) + ", " + names.parameters[kA1],
             names.unit_slow,
             std::nullopt};
  lower.weight = 1.15;
  for (int i = 0; i < kFamilySize; ++i) {
    const int estimator = names.first + i;
    const std::string window =
        WindowName(core::kEstimatorShapes[static_cast<std::size_t>(estimator)]);
    Series b0 = MakeEstimateSeries(frames, estimator, kB0, kInks[i], Dash::kSolid);
    b0.name = window;
    upper.series.push_back(std::move(b0));
    Series b1 = MakeEstimateSeries(frames, estimator, kB1, kInks[i], Dash::kSolid);
    Series a1 = MakeEstimateSeries(frames, estimator, kA1, kInks[i], Dash::kDashed);
    lower.series.push_back(std::move(b1));
    lower.series.push_back(std::move(a1));
  }
  Series key_b1;
  key_b1.name = names.parameters[kB1];
  key_b1.ink = Ink::kBlack;
  Series key_a1 = key_b1;
  key_a1.name = names.parameters[kA1];
  key_a1.dash = Dash::kDashed;
  lower.series.push_back(std::move(key_b1));
  lower.series.push_back(std::move(key_a1));

  if (nominal) {
    const auto level = [&](int parameter) {
      return Level{(*nominal)[static_cast<std::size_t>(parameter)],
                   std::string(names.parameters[parameter]) + " nom.",
                   Ink::kGrey};
    };
    upper.levels.push_back(level(kB0));
    lower.levels.push_back(level(kB1));
    lower.levels.push_back(level(kA1));
  }
  if (const std::optional<double> change = FirstChange(context); change && frames.size() > 1) {
    const double period_s = MeanPeriod(frames.front().sample, frames.back().sample);
    AddSettlingBands(upper, *change, period_s, names.first, true);
    AddSettlingBands(lower, *change, period_s, names.first, false);
  }
  upper.y.range = BulkRange(upper);
  lower.y.range = BulkRange(lower);
  figure.panels.push_back(std::move(upper));
  figure.panels.push_back(std::move(lower));
  return figure;
}

}  // namespace faultlab::server
