#include <algorithm>

#include "core/types/check.h"
#include "server/plots/figure_parts.h"
#include "server/plots/figures.h"
#include "server/plots/ticks.h"

namespace faultlab::server {
namespace {

/// The appearance of each model; the measurement is black.
struct Look {
  Ink ink;
  Dash dash;
};
constexpr Look kLooks[] = {{Ink::kBlue, Dash::kSolid},
                           {Ink::kVermilion, Dash::kSolid},
                           {Ink::kSky, Dash::kDashed},
                           {Ink::kGreen, Dash::kDashed},
                           {Ink::kOrange, Dash::kDashed},
                           {Ink::kPurple, Dash::kSolid}};

/// What is not nominal during the stretch, which follows the newest change: each component as it
/// was set last.
std::vector<std::string> Present(const FigureContext& context, const ModelComparison& comparison) {
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < context.faults.size(); ++i) {
    const core::Fault& fault = context.faults[i];
    const auto replaces = [&](const core::Fault& later) {
      return later.component == fault.component &&
             (comparison.t_s.empty() || later.at_s <= comparison.t_s.back());
    };
    const auto rest = context.faults.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    if (std::any_of(rest, context.faults.end(), replaces)) continue;
    FigureContext only;
    only.faults = {fault};
    for (const Mark& mark : MakeMarks(only)) {
      if (mark.kind == MarkKind::kFault) labels.push_back(mark.label);
    }
  }
  return labels;
}

}  // namespace

Figure MakeModelsFigure(const ModelComparison& comparison,
                        const FigureContext& context,
                        double shown_s) {
  LAB_CHECK(comparison.t_s.size() == comparison.y.size());
  Figure figure = MakeFigureOf("Measured and simulated output", context);
  for (const std::string& fault : Present(context, comparison)) {
    figure.subtitle += (figure.subtitle.empty() ? "" : ", ") + fault;
  }
  // Several frictions have several chances.
  const auto best = std::ranges::max_element(
      comparison.models, {}, [](const ModelOutput& model) { return model.fit_percent; });
  if (best != comparison.models.end() && best->key.starts_with("model_mc_")) {
    figure.subtitle += (figure.subtitle.empty() ? "" : ". ") +
                       std::string(
                           "No model is fitted to this stretch: one of several frictions "
                           "can come nearest by chance");
  }
  figure.marks.clear();
  std::size_t shown = comparison.t_s.size();
  if (shown > 0) {
    const double end = comparison.t_s.front() + shown_s;
    shown = static_cast<std::size_t>(
        std::upper_bound(comparison.t_s.begin(), comparison.t_s.end(), end) -
        comparison.t_s.begin());
  }
  const auto cut = [shown](const std::vector<double>& values) {
    return std::vector<double>(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(shown));
  };
  const std::vector<double> t = cut(comparison.t_s);

  Panel output;
  const core::EstimatedChannelInfo& channel = core::InfoOf(comparison.channel);
  const std::string unit(channel.unit);
  output.y = {std::string(channel.symbol), unit, std::nullopt};
  output.weight = 2.0;
  Panel residual;
  residual.y = {"Residual", unit, std::nullopt};
  residual.levels.push_back({0.0, "", Ink::kGrey});

  Series measured;
  measured.name = "measured";
  measured.ink = Ink::kBlack;
  measured.width = 2.4;
  measured.x = t;
  measured.y = cut(comparison.y);
  output.series.push_back(std::move(measured));
  std::size_t i = 0;
  for (const ModelOutput& model : comparison.models) {
    LAB_CHECK(model.y.size() == comparison.t_s.size(), model.name, model.y.size());
    Series series;
    const Look& look = kLooks[i++ % std::size(kLooks)];
    series.name = model.name + "  " + FormatNumber(model.fit_percent, 1) + " %";
    series.ink = look.ink;
    series.dash = look.dash;
    series.x = t;
    series.y = cut(model.y);
    Series error = series;
    error.name.clear();
    for (std::size_t k = 0; k < shown; ++k) {
      error.y[k] = comparison.y[k] - model.y[k];
    }
    output.series.push_back(std::move(series));
    residual.series.push_back(std::move(error));
  }
  figure.panels.push_back(std::move(output));
  figure.panels.push_back(std::move(residual));
  return figure;
}

}  // namespace faultlab::server
