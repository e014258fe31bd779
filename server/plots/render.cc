#include "server/plots/render.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/plots/canvas.h"
#include "server/plots/flow_painter.h"
#include "server/plots/marks_painter.h"
#include "server/plots/matrix_painter.h"
#include "server/plots/panel_painter.h"
#include "server/plots/png.h"
#include "server/plots/typeface.h"

namespace faultlab::server {
namespace {

constexpr double kOuterMargin = 18;
constexpr double kMarkStrip = 34;
constexpr double kMarkRow = 24;  // each further row of marks
constexpr double kPixelsPerXTick = 120;
/// 1600 pixels fill the 170 mm between the margins of an A4 page.
constexpr double kPixelsPerMetre = 1600 / 0.170;

std::pair<double, double> XRange(const Figure& figure) {
  if (figure.x.range) {
    return *figure.x.range;
  }
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Panel& panel : figure.panels) {
    for (const Series& series : panel.series) {
      if (!series.x.empty()) {
        low = std::min(low, series.x.front());
        high = std::max(high, series.x.back());
      }
    }
  }
  return low < high ? std::pair(low, high) : std::pair(0.0, 1.0);
}

/// Draws title, subtitle and footer; returns the remaining area.
PixelRect DrawHeading(Canvas& canvas, const PlotStyle& style, const Figure& figure) {
  const int margin = style.Px(kOuterMargin);
  int top = margin;
  const double middle = 0.5 * canvas.width();
  const auto heading = [&](const std::string& text, int size_px, Rgb colour) {
    if (text.empty()) {
      return;
    }
    canvas.Text(text, middle, top + 0.6 * size_px, size_px, colour, Align::kCentre);
    top += static_cast<int>(std::lround(1.35 * size_px));
  };
  heading(figure.title, style.title_px, kTextColour);
  heading(figure.subtitle, style.subtitle_px, kQuietColour);
  int bottom = canvas.height() - style.Px(10);
  if (!figure.footer.empty()) {
    canvas.Text(figure.footer,
                canvas.width() - margin,
                bottom - 0.5 * style.footer_px,
                style.footer_px,
                kQuietColour,
                Align::kRight);
    bottom -= style.footer_px + style.Px(6);
  }
  return {margin, top, canvas.width() - 2 * margin, bottom - top};
}

/// Heights first, then ticks, then the width of their labels, because the panels share their left
/// and right edges.
void PlacePanels(std::vector<PanelPainter>& painters,
                 const Figure& figure,
                 const PlotStyle& style,
                 const PixelRect& area,
                 std::pair<double, double> x_range) {
  const auto place = [&](int left, int right) {
    const int width = area.right() - right - (area.left + left);
    int free = area.height;
    double weights = 0.0;
    for (std::size_t i = 0; i < painters.size(); ++i) {
      free -= painters[i].HeadHeight(width);
      weights += figure.panels[i].weight;
    }
    const int x_tick_count = std::max(2, width / style.Px(kPixelsPerXTick));
    const Ticks x_ticks = MakeTicks(x_range.first, x_range.second, x_tick_count);
    int top = area.top;
    for (std::size_t i = 0; i < painters.size(); ++i) {
      top += painters[i].HeadHeight(width);
      const int height = std::max(20, static_cast<int>(free * figure.panels[i].weight / weights));
      painters[i].SetPlot({area.left + left, top, width, height}, x_range, x_ticks);
      top += height;
    }
  };
  const int label = static_cast<int>(1.5 * style.label_px);
  int left = label + style.Px(60);
  int right = style.Px(20);
  place(left, right);
  int ticks = 0;
  int levels = 0;
  for (const PanelPainter& painter : painters) {
    ticks = std::max(ticks, painter.TickLabelWidth());
    levels = std::max(levels, painter.LevelLabelWidth());
  }
  left = label + ticks + style.Px(14);
  right = levels > 0 ? levels + style.Px(10) : style.Px(20);
  place(left, right);
}

void DrawXAxis(Canvas& canvas,
               const PlotStyle& style,
               const Figure& figure,
               const PlotScale& scale) {
  const int count = std::max(2, scale.plot.width / style.Px(kPixelsPerXTick));
  const Ticks ticks = MakeTicks(scale.x.first, scale.x.second, count);
  const double numbers_y = scale.plot.bottom() + style.Px(10) + 0.5 * style.tick_px;
  for (std::size_t i = 0; i < ticks.at.size(); ++i) {
    canvas.Text(ticks.labels[i],
                scale.ToX(ticks.at[i]),
                numbers_y,
                style.tick_px,
                kTextColour,
                Align::kCentre);
  }
  canvas.Text(AxisText(figure.x, ticks.exponent),
              scale.plot.left + 0.5 * scale.plot.width,
              numbers_y + style.tick_px + style.Px(4),
              style.label_px,
              kTextColour,
              Align::kCentre);
}

void DrawPanels(Canvas& canvas, const PlotStyle& style, const Figure& figure, PixelRect area) {
  const int x_axis_height = style.tick_px + style.label_px + style.Px(24);
  area.height -= x_axis_height;
  const auto add_strip = [&](double height) {
    area.top += style.Px(height);
    area.height -= style.Px(height);
  };
  if (!figure.marks.empty()) add_strip(kMarkStrip);
  std::vector<PanelPainter> painters;
  for (const Panel& panel : figure.panels) {
    painters.emplace_back(canvas, style, panel);
  }
  PlacePanels(painters, figure, style, area, XRange(figure));
  const MarkLane narrow(canvas, style, figure.marks, painters.front().plot_scale());
  if (narrow.rows() > 1) {
    add_strip((narrow.rows() - 1) * kMarkRow);
    PlacePanels(painters, figure, style, area, XRange(figure));
  }
  for (PanelPainter& painter : painters) {
    painter.DrawGround();
    DrawMarkLines(canvas, style, figure.marks, painter.plot_scale());
    painter.DrawSeries();
    painter.DrawFrame(area.left + 0.6 * style.label_px);
  }
  // The labels are above the legend of the first panel.
  MarkLane(canvas, style, figure.marks, painters.front().plot_scale())
      .Draw(area.top - 0.5 * style.Px(kMarkStrip), style.Px(kMarkRow));
  DrawXAxis(canvas, style, figure, painters.back().plot_scale());
}

Canvas Draw(const Figure& figure, int width, int height, const PlotStyle& style, Typeface& type) {
  Canvas canvas(width, height, type);
  const PixelRect area = DrawHeading(canvas, style, figure);
  if (!figure.matrix.rows.empty()) {
    DrawMatrix(canvas, style, figure.matrix, area);
  } else if (!figure.flow.empty()) {
    DrawFlow(canvas, style, figure.flow, area);
  } else if (!figure.panels.empty()) {
    DrawPanels(canvas, style, figure, area);
  }
  return canvas;
}

}  // namespace

core::Result<std::string> RenderPng(const Figure& figure, const RenderOptions& options) {
  const auto invalid = [](const std::string& text, const std::string& field) {
    return core::Error{core::ErrorCode::kInvalid, text, field};
  };
  if (options.scale < 1 || options.scale > 2) {
    return invalid("scale must be 1 or 2", "scale");
  }
  if (options.width_px < 400 || options.width_px > 4000) {
    return invalid("width must be 400 to 4000 pixels", "width");
  }
  if (options.height_px < 300 || options.height_px > 4000) {
    return invalid("height must be 300 to 4000 pixels", "height");
  }
  TRY(auto type, Typeface::Load(options.font_path));
  const Canvas canvas = Draw(figure,
                             options.width_px * options.scale,
                             options.height_px * options.scale,
                             PlotStyle(options.scale),
                             *type);
  const auto density = static_cast<std::uint32_t>(std::lround(kPixelsPerMetre * options.scale));
  return EncodePng(canvas.pixels(),
                   canvas.width(),
                   canvas.height(),
                   std::clamp(options.png_level, 1, 9),
                   density);
}

core::Result<Pixels> RenderForPrint(const Figure& figure,
                                    double width_mm,
                                    double height_mm,
                                    const std::string& font_path) {
  if (!(width_mm >= 80 && width_mm <= 300 && height_mm >= 50 && height_mm <= 300)) {
    return core::Error{core::ErrorCode::kInvalid,
                       "a figure on paper is 80 to 300 mm wide, 50 to 300 mm high",
                       "",
                       "internal"};
  }
  TRY(auto type, Typeface::Load(font_path));
  constexpr double kMmPerInch = 25.4;
  constexpr double kMmPerMetre = 1000.0;
  constexpr double kLarger = 1.1;  // text of 7 points
  constexpr double kPixelsPerMm = kPrintDpi / kMmPerInch;
  const Canvas canvas = Draw(figure,
                             static_cast<int>(std::lround(width_mm * kPixelsPerMm)),
                             static_cast<int>(std::lround(height_mm * kPixelsPerMm)),
                             PlotStyle(kLarger * kPixelsPerMm * kMmPerMetre / kPixelsPerMetre),
                             *type);
  const std::span<const std::uint8_t> drawn = canvas.pixels();
  Pixels out{canvas.width(), canvas.height(), {}};
  out.rgb.assign(drawn.data(), drawn.data() + drawn.size());
  return out;
}

}  // namespace faultlab::server
