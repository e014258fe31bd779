#include "server/plots/comparison_figure.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/types/check.h"
#include "server/plots/figure_parts.h"

namespace faultlab::server {
namespace {

struct RunLook {
  Ink ink;
  Dash dash;
};
constexpr std::array<RunLook, kComparedMax> kRunLooks = {{{Ink::kBlue, Dash::kSolid},
                                                          {Ink::kVermilion, Dash::kDashed},
                                                          {Ink::kGreen, Dash::kDotted},
                                                          {Ink::kPurple, Dash::kDashed}}};

void Shift(std::vector<double>& x, double by_s) {
  for (double& at : x) at -= by_s;
}

Panel SignalPanel(std::span<const ComparedRecord> records) {
  Panel panel;
  panel.y = {"", "", {}};
  for (const core::EstimatedChannelInfo& channel : core::kEstimatedChannels) {
    const auto is_of = [&](const ComparedRecord& record) {
      return &core::InfoOf(record.estimated) == &channel;
    };
    if (!records.empty() && std::ranges::none_of(records, is_of)) continue;
    if (records.empty() && channel.row != 0) continue;
    panel.y.label += (panel.y.label.empty() ? "" : ", ") + std::string(channel.symbol);
    panel.y.unit += (panel.y.unit.empty() ? "" : ", ") + std::string(channel.unit);
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    const ComparedRecord& record = records[i];
    Series series =
        MakeChannelSeries(record.samples, core::InfoOf(record.estimated).reading, kRunLooks[i].ink);
    series.dash = kRunLooks[i].dash;
    series.width = 1.0;
    series.name = record.name;
    Shift(series.x, record.zero_s);
    panel.series.push_back(std::move(series));
  }
  return panel;
}

}  // namespace

Figure MakeComparisonFigure(std::span<const ComparedRecord> records,
                            EstimatorFamily family,
                            bool aligned,
                            const std::string& footer) {
  LAB_CHECK(records.size() <= kComparedMax, records.size());
  std::vector<EstimateCurve> curves;
  for (const ComparedRecord& record : records) {
    EstimateCurve curve = record.curve;
    curve.name.clear();  // the legend stands above the signals
    Shift(curve.t_s, record.zero_s);
    curves.push_back(std::move(curve));
  }
  FigureContext context;
  context.footer = footer;
  if (!records.empty()) context.estimated = records.front().estimated;
  Figure figure = MakeCurvesFigure(std::move(curves), family, context);
  figure.title = "Runs compared";
  if (!records.empty()) {
    figure.subtitle = (family == EstimatorFamily::kSwa ? "SWA " : "SIA ") + records[0].curve.name;
  }
  if (aligned) {
    figure.x.label = "Time since the change";
    figure.marks.push_back({MarkKind::kFault, 0.0, "fault"});
  }
  for (Panel& panel : figure.panels) {
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      panel.series[i].ink = kRunLooks[i].ink;
      panel.series[i].dash = kRunLooks[i].dash;
    }
  }
  Panel signals = SignalPanel(records);
  signals.weight = 1.6;
  figure.x.range.reset();
  double from = 0.0;
  double to = 0.0;
  for (const ComparedRecord& record : records) {
    if (record.samples.size() < 2) continue;
    const auto [begin, end] = WholeTime(record.samples.front(), record.samples.back());
    from = std::min(from, begin - record.zero_s);
    to = std::max(to, end - record.zero_s);
  }
  if (from < to) figure.x.range = {from, to};
  constexpr double kLensPlaceShare = 0.42;
  constexpr double kBefore = 0.2;  // s before the change
  if (to - from > 4 * kLensSeconds) {
    AddLens(signals, aligned ? -kBefore : from + kLensPlaceShare * (to - from));
  }
  figure.panels.insert(figure.panels.begin(), std::move(signals));
  return figure;
}

}  // namespace faultlab::server
