#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/types/check.h"
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
};

constexpr FamilyNames kSwaNames = {"Estimates of the sliding window algorithm (SWA)",
                                   {"b_{0d}", "b_{1d}", "a_{1d}"}};
constexpr FamilyNames kSiaNames = {"Estimates of the sliding integral algorithm (SIA)",
                                   {"b_{0}", "b_{1}", "a_{1}"}};

/// Range of most of the values. A short window may give a few extreme estimates, and so does the
/// start-up; in their range all other values would look flat.
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
    std::ranges::copy_if(
        series.y, std::back_inserter(values), [](double value) { return std::isfinite(value); });
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

double PeriodOf(const std::vector<double>& t_s) {
  return (t_s.back() - t_s.front()) / static_cast<double>(t_s.size() - 1);
}

void AddSettlingBands(Panel& panel,
                      double change_s,
                      std::span<const EstimateCurve> curves,
                      bool named) {
  for (const EstimateCurve& curve : curves) {
    if (curve.t_s.size() < 2) {
      continue;
    }
    Band band;
    band.x_from = change_s;
    band.x_to = change_s + curve.settling_samples * PeriodOf(curve.t_s);
    if (named) {
      band.name = "windows settling";
      named = false;
    }
    panel.bands.push_back(band);
  }
}

/// Takes the values from the curve.
Series TakeSeries(EstimateCurve& curve, int parameter, Ink ink, Dash dash) {
  Series series;
  series.ink = ink;
  series.dash = dash;
  series.x = curve.t_s;
  series.y = std::move(curve.theta[static_cast<std::size_t>(parameter)]);
  return series;
}

}  // namespace

std::string WindowName(int window_samples, int integral_samples) {
  return integral_samples == 0 ? "K = " + std::to_string(window_samples)
                               : "(K, m) = (" + std::to_string(window_samples) + ", " +
                                     std::to_string(integral_samples) + ")";
}

bool IsDrawable(core::EstimateStatus status,
                int age_samples,
                const std::array<double, 3>& sigma,
                int parameter) {
  const bool computed =
      status == core::EstimateStatus::kExcited || status == core::EstimateStatus::kWeak;
  return computed && age_samples == 0 &&
         (parameter == kB0 ? std::isfinite(sigma[kB0]) : std::isfinite(sigma[kB1] + sigma[kA1]));
}

EstimatorFamily FamilyOf(core::EstimatorId estimator) {
  const core::EstimatorShape& shape = core::kEstimatorShapes[static_cast<std::size_t>(estimator)];
  return shape.integral_samples == 0 ? EstimatorFamily::kSwa : EstimatorFamily::kSia;
}

std::array<core::EstimatorId, kFamilySize> EstimatorsOf(EstimatorFamily family) {
  using enum core::EstimatorId;
  if (family == EstimatorFamily::kSwa) return {kSwa50, kSwa100, kSwa200};
  return {kSia20x5, kSia100x20, kSia500x20};
}

EstimateCurve EmptyCurve(core::EstimatorId estimator) {
  const core::EstimatorShape& shape = core::kEstimatorShapes[static_cast<std::size_t>(estimator)];
  EstimateCurve curve;
  curve.name = WindowName(shape.window_samples, shape.integral_samples);
  curve.settling_samples = shape.window_samples + shape.integral_samples - 1;
  return curve;
}

void Append(const core::Frame& frame, core::EstimatorId estimator, EstimateCurve& curve) {
  const core::Estimate<3> estimate =
      core::Shown(frame.estimates[static_cast<std::size_t>(estimator)]);
  curve.t_s.push_back(frame.sample.t_s);
  for (int parameter = 0; parameter < kFamilySize; ++parameter) {
    const auto at = static_cast<std::size_t>(parameter);
    curve.theta[at].push_back(
        IsDrawable(estimate.status, estimate.age_samples, estimate.sigma, parameter)
            ? estimate.theta[at]
            : core::kAbsent);
  }
}

Figure MakeEstimatesFigure(std::span<const core::Frame> frames,
                           EstimatorFamily family,
                           const FigureContext& context) {
  std::vector<EstimateCurve> curves;
  for (const core::EstimatorId estimator : EstimatorsOf(family)) {
    EstimateCurve& curve = curves.emplace_back(EmptyCurve(estimator));
    for (const core::Frame& frame : frames) Append(frame, estimator, curve);
  }
  return MakeCurvesFigure(std::move(curves), family, context);
}

Figure MakeCurvesFigure(std::vector<EstimateCurve> curves,
                        EstimatorFamily family,
                        const FigureContext& context) {
  struct Look {
    Ink ink;
    Dash dash;
  };
  constexpr std::array<Look, kEstimateCurvesMax> kLooks = {{{Ink::kGreen, Dash::kDotted},
                                                            {Ink::kBlue, Dash::kSolid},
                                                            {Ink::kPurple, Dash::kDashed},
                                                            {Ink::kVermilion, Dash::kDotted},
                                                            {Ink::kBlack, Dash::kSolid},
                                                            {Ink::kOrange, Dash::kDashed}}};
  LAB_CHECK(curves.size() <= kEstimateCurvesMax, curves.size());
  const bool swa = family == EstimatorFamily::kSwa;
  const FamilyNames& names = swa ? kSwaNames : kSiaNames;
  const std::optional<std::array<double, 3>>& nominal =
      swa ? context.nominal_swa : context.nominal_sia;
  Figure figure = MakeFigureOf(names.title, context);

  const bool drawn = !curves.empty() && curves.front().t_s.size() > 1;
  if (drawn) {
    const std::vector<double>& t_s = curves.front().t_s;
    figure.x.range = {t_s.front(), t_s.back() + PeriodOf(t_s)};
  }
  const std::string unit(core::InfoOf(context.estimated).unit);
  const std::string gain = unit + "/V";
  const std::string lead = unit == "V" ? "s" : unit + "·s/V";
  const std::array<std::string, kFamilySize> units = {
      gain, swa ? gain : lead, swa ? unit + "/" + unit : "s"};
  const std::vector<double> changes = ChangeTimes(context);
  for (int parameter = 0; parameter < kFamilySize; ++parameter) {
    const auto at = static_cast<std::size_t>(parameter);
    Panel panel;
    panel.y = {names.parameters[at], units[at], std::nullopt};
    for (std::size_t i = 0; i < curves.size(); ++i) {
      panel.series.push_back(TakeSeries(curves[i], parameter, kLooks[i].ink, kLooks[i].dash));
      if (parameter == kB0) {
        panel.series.back().name = curves[i].name;
      }
    }
    if (nominal) {
      panel.levels.push_back(
          {(*nominal)[at], std::string(names.parameters[at]) + " nom.", Ink::kGrey});
    }
    for (std::size_t i = 0; i < changes.size() && drawn; ++i) {
      AddSettlingBands(panel, changes[i], curves, parameter == kB0 && i == 0);
    }
    panel.y.range = BulkRange(panel);
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace faultlab::server
