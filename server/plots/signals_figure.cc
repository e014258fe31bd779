#include <algorithm>
#include <cmath>

#include "server/plots/figure_parts.h"
#include "server/plots/figures.h"

namespace faultlab::server {
namespace {

constexpr double kLineWidth = 1.0;        // for 2000 points on 1400 pixels
constexpr double kLensPlaceShare = 0.42;  // of the recording, so that it stays clear of the middle

bool HoldsNumbers(const Series& series) {
  return std::ranges::any_of(series.y, [](double value) { return std::isfinite(value); });
}

Panel MakePanel(const std::string& label, const std::string& unit, double weight) {
  Panel panel;
  panel.y = {label, unit, std::nullopt};
  panel.weight = weight;
  return panel;
}

/// The control voltage, with a magnified second of it (paper Fig. 14).
Panel MakeInputPanel(std::span<const core::Sample> samples) {
  Panel panel = MakePanel("U_{c}", "V", 1.35);
  Series series = MakeChannelSeries(samples, &core::Sample::uc_v, Ink::kBlue);
  series.stair = true;
  series.width = kLineWidth;
  panel.series.push_back(std::move(series));
  if (!samples.empty()) {
    const double start = samples.front().t_s;
    const double length = samples.back().t_s - start;
    if (length > 4 * kLensSeconds) AddLens(panel, start + std::floor(kLensPlaceShare * length));
  }
  return panel;
}

/// The speed that the rig was to have.
Series ReferenceOf(const FigureContext& context) {
  Series series;
  series.name = "reference";
  series.ink = Ink::kGrey;
  series.dash = Dash::kDashed;
  series.width = kLineWidth;
  series.x = context.reference_t_s;
  series.y = context.reference_n_rpm;
  return series;
}

}  // namespace

Figure MakeSignalsFigure(std::span<const core::Sample> samples, const FigureContext& context) {
  Figure figure = MakeFigureOf("Measured signals", context);
  if (samples.size() > 1) {
    figure.x.range = WholeTime(samples.front(), samples.back());
  }
  figure.panels.push_back(MakeInputPanel(samples));

  Panel output = MakePanel("U_{m}", "V", 1.0);
  Series ua = MakeChannelSeries(samples, &core::Sample::ua_v, Ink::kGreen);
  ua.width = kLineWidth;
  ua.dash = Dash::kDashed;
  Series um = MakeChannelSeries(samples, &core::Sample::um_v, Ink::kVermilion);
  um.width = kLineWidth;
  if (HoldsNumbers(ua)) {
    output.y.label = "U_{m}, U_{a}";
    ua.name = "U_{a}, of the amplifier";
    um.name = "U_{m}, over the motor";
    output.series.push_back(std::move(ua));
  }
  if (HoldsNumbers(um)) output.series.push_back(std::move(um));
  if (!output.series.empty()) figure.panels.push_back(std::move(output));

  struct Optional {
    double core::Sample::*channel;
    const char* label;
    const char* unit;
    Ink ink;
  };
  for (const Optional& one : {Optional{&core::Sample::ia_a, "I_{a}", "A", Ink::kPurple},
                              Optional{&core::Sample::n_rpm, "n", "rpm", Ink::kSky}}) {
    Series series = MakeChannelSeries(samples, one.channel, one.ink);
    if (HoldsNumbers(series)) {
      series.width = kLineWidth;
      Panel panel = MakePanel(one.label, one.unit, 0.9);
      if (one.channel == &core::Sample::n_rpm && !context.reference_t_s.empty()) {
        series.name = "measured";
        panel.series.push_back(ReferenceOf(context));
      }
      panel.series.push_back(std::move(series));
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

Figure MakeOverlayFigure(const std::vector<OverlayPanel>& panels, const FigureContext& context) {
  constexpr Ink kInks[] = {Ink::kBlue, Ink::kVermilion, Ink::kGreen, Ink::kPurple, Ink::kOrange};
  constexpr Dash kDashes[] = {Dash::kSolid, Dash::kDashed, Dash::kDotted};
  const bool of_um = panels.empty() || panels.front().channel == core::EstimatedChannel::kUm;
  Figure figure = MakeFigureOf(of_um ? "Amplifier output voltage" : "Measured signal", context);
  for (const OverlayPanel& overlay : panels) {
    const core::EstimatedChannelInfo& channel = core::InfoOf(overlay.channel);
    Panel panel = MakePanel(std::string(channel.symbol), std::string(channel.unit), 1.0);
    panel.title = overlay.title;
    std::size_t i = 0;
    for (const OverlayTrace& trace : overlay.traces) {
      Series series;
      series.name = trace.name;
      series.ink = kInks[i % std::size(kInks)];
      series.dash = kDashes[i++ / std::size(kInks) % std::size(kDashes)];
      series.width = kLineWidth;
      series.x = trace.t_s;
      series.y = trace.y;
      if (series.x.size() > 1 && !figure.x.range) {
        const double period_s = series.x[1] - series.x[0];
        figure.x.range = {series.x.front(), series.x.back() + period_s};
      }
      panel.series.push_back(std::move(series));
    }
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace faultlab::server
