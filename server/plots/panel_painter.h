#pragma once

#include <string>
#include <vector>

#include "server/plots/canvas.h"
#include "server/plots/figure.h"
#include "server/plots/ticks.h"
#include "server/plots/trace.h"

namespace faultlab::server {

/// Sizes in pixels, all multiplied by the picture's scale.
struct PlotStyle {
  explicit PlotStyle(double scale_in);
  int Px(double at_scale_one) const;

  double scale;
  int line_px;  ///< of grid and frames
  int title_px, subtitle_px, label_px, tick_px, legend_px, footer_px, inset_px;
};

std::string AxisText(const Axis& axis, int exponent);

/// One panel and everything that belongs to it alone.
class PanelPainter {
 public:
  PanelPainter(Canvas& canvas, const PlotStyle& style, const Panel& panel);

  /// Height of title and legend above the panel, for this `width`.
  int HeadHeight(int width) const;
  /// Sets the y range and the height; computes the ticks.
  void SetPlot(const PixelRect& plot, std::pair<double, double> x_range, const Ticks& x_ticks);
  int TickLabelWidth() const;
  int LevelLabelWidth() const;

  /// Background, bands, grid and levels, which lie below marks and series.
  void DrawGround();
  void DrawSeries();
  /// Frame, numbers, label, legend, inset.
  void DrawFrame(double y_label_x);

  const PlotScale& plot_scale() const { return scale_; }

 private:
  struct LegendEntry {
    std::string text;
    const Series* series = nullptr;
    const Band* band = nullptr;
    int width = 0;
  };

  std::vector<std::vector<LegendEntry>> LegendRows(int width) const;
  void DrawHead();
  void DrawLegendEntry(const LegendEntry& entry, double x, double y);
  void DrawLevelLabels();
  void DrawInset(const Inset& inset);
  void DrawSeriesOn(const PlotScale& scale, double dash_unit_px);
  Stroke StrokeOf(const Series& series) const;

  Canvas& canvas_;
  const PlotStyle& style_;
  const Panel& panel_;
  PlotScale scale_;
  Ticks x_ticks_;
  Ticks y_ticks_;
};

/// Range of the panel's y axis: the given one, or that of its data with a margin.
std::pair<double, double> YRange(const Panel& panel);

}  // namespace faultlab::server
