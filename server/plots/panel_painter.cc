#include "server/plots/panel_painter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace faultlab::server {
namespace {

constexpr double kBandShare = 0.09;
constexpr double kSwatch = 34;    // length of a legend line
constexpr double kSwatchGap = 8;  // between the line and its text
constexpr double kEntryGap = 26;  // between entries
constexpr double kLegendRow = 28;
constexpr double kTickLength = 6;
constexpr double kLabelGap = 10;
constexpr double kPixelsPerTick = 34;

/// Moves label heights apart so that neighbours have `distance`; their order stays ascending.
void SpreadApart(std::vector<double>& places, double distance, double lowest, double highest) {
  for (std::size_t i = 1; i < places.size(); ++i) {
    places[i] = std::max(places[i], places[i - 1] + distance);
  }
  for (std::size_t i = places.size(); i-- > 0;) {
    const double limit = i + 1 == places.size() ? highest : places[i + 1] - distance;
    places[i] = std::max(lowest, std::min(places[i], limit));
  }
}

}  // namespace

PlotStyle::PlotStyle(double scale_in)
    : scale(scale_in),
      line_px(Px(1)),
      title_px(Px(28)),
      subtitle_px(Px(19)),
      label_px(Px(22)),
      tick_px(Px(19)),
      legend_px(Px(19)),
      footer_px(Px(15)),
      inset_px(Px(15)) {}

int PlotStyle::Px(double at_scale_one) const {
  return static_cast<int>(std::lround(at_scale_one * scale));
}

std::string AxisText(const Axis& axis, int exponent) {
  std::string unit = axis.unit;
  if (exponent != 0) {
    unit = "10^{" + FormatNumber(exponent, 0) + "}" + (unit.empty() ? "" : " " + unit);
  }
  return unit.empty() ? axis.label : axis.label + " (" + unit + ")";
}

std::pair<double, double> YRange(const Panel& panel) {
  if (panel.y.range) {
    return *panel.y.range;
  }
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto take = [&](double value) {
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  };
  for (const Series& series : panel.series) {
    if (series.scale.value_or(true)) {
      std::for_each(series.y.begin(), series.y.end(), take);
    }
  }
  for (const Level& level : panel.levels) {
    take(level.y);
  }
  return low <= high ? WithMargin(low, high) : std::pair(0.0, 1.0);
}

PanelPainter::PanelPainter(Canvas& canvas, const PlotStyle& style, const Panel& panel)
    : canvas_(canvas), style_(style), panel_(panel) {}

void PanelPainter::SetPlot(const PixelRect& plot,
                           std::pair<double, double> x_range,
                           const Ticks& x_ticks) {
  scale_ = {plot, x_range, YRange(panel_)};
  x_ticks_ = x_ticks;
  const int count = std::max(2, static_cast<int>(plot.height / style_.Px(kPixelsPerTick)));
  y_ticks_ = MakeTicks(scale_.y.first, scale_.y.second, count);
  if (panel_.inset) {  // numbers beside the inset would not belong to its scale
    double highest = -std::numeric_limits<double>::infinity();
    for (const Series& series : panel_.series) {
      for (const double value : series.y) {
        highest = std::isfinite(value) ? std::max(highest, value) : highest;
      }
    }
    while (!y_ticks_.at.empty() && y_ticks_.at.back() > highest + 0.1 * std::abs(highest)) {
      y_ticks_.at.pop_back();
      y_ticks_.labels.pop_back();
    }
  }
}

int PanelPainter::TickLabelWidth() const {
  int width = 0;
  for (const std::string& label : y_ticks_.labels) {
    width = std::max(width, canvas_.TextWidth(label, style_.tick_px));
  }
  return width;
}

int PanelPainter::LevelLabelWidth() const {
  int width = 0;
  for (const Level& level : panel_.levels) {
    if (!level.label.empty()) {
      width = std::max(width, canvas_.TextWidth(level.label, style_.legend_px));
    }
  }
  return width;
}

Stroke PanelPainter::StrokeOf(const Series& series) const {
  return {ColourOf(series.ink),
          std::max(1, style_.Px(series.width)),
          series.dash,
          static_cast<double>(style_.Px(4))};
}

void PanelPainter::DrawGround() {
  const PixelRect& plot = scale_.plot;
  for (const Band& band : panel_.bands) {
    const auto x = [&](double value) {
      return std::clamp(static_cast<int>(std::lround(scale_.ToX(value))), plot.left, plot.right());
    };
    const auto y = [&](double value) {
      return std::clamp(static_cast<int>(std::lround(scale_.ToY(value))), plot.top, plot.bottom());
    };
    const int left = band.x_from ? x(*band.x_from) : plot.left;
    const int right = band.x_to ? x(*band.x_to) : plot.right();
    const int top = band.y_to ? y(*band.y_to) : plot.top;
    const int bottom = band.y_from ? y(*band.y_from) : plot.bottom();
    canvas_.Shade({left, top, right - left, bottom - top}, ColourOf(band.ink), kBandShare);
  }
  const Stroke grid = {kGridColour, style_.line_px};
  for (const double at : x_ticks_.at) {
    const double x = std::round(scale_.ToX(at)) + 0.5;
    canvas_.Line({x, plot.top + 0.5}, {x, plot.bottom() + 0.5}, grid);
  }
  for (const double at : y_ticks_.at) {
    const double y = std::round(scale_.ToY(at)) + 0.5;
    canvas_.Line({plot.left + 0.5, y}, {plot.right() + 0.5, y}, grid);
  }
}

void PanelPainter::DrawSeriesOn(const PlotScale& scale, double dash_unit_px) {
  for (const Series& series : panel_.series) {
    Stroke stroke = StrokeOf(series);
    stroke.dash_unit_px = dash_unit_px;
    for (const std::vector<PixelPoint>& trace : MakeTraces(series, scale)) {
      if (trace.size() == 1) {
        const PixelPoint dot = trace.front();
        const PixelRect& plot = scale.plot;
        if (dot.x >= plot.left && dot.x <= plot.right() && dot.y >= plot.top &&
            dot.y <= plot.bottom()) {
          canvas_.Disc(dot, style_.Px(2.5), stroke.colour);
        }
        continue;
      }
      canvas_.Polyline(trace, stroke, scale.plot);
    }
  }
}

void PanelPainter::DrawSeries() {
  const PixelRect& plot = scale_.plot;
  DrawSeriesOn(scale_, style_.Px(4));
  for (const Level& level : panel_.levels) {
    if (level.y < scale_.y.first || level.y > scale_.y.second) {
      continue;
    }
    const double y = scale_.ToY(level.y);
    const PixelPoint line[] = {{static_cast<double>(plot.left), y},
                               {static_cast<double>(plot.right()), y}};
    canvas_.Polyline(line,
                     {ColourOf(level.ink),
                      std::max(1, style_.Px(1.4)),
                      Dash::kDashed,
                      static_cast<double>(style_.Px(4))},
                     plot);
  }
}

void PanelPainter::DrawFrame(double y_label_x) {
  const PixelRect& plot = scale_.plot;
  const Stroke frame = {kTextColour, style_.line_px};
  canvas_.Frame(plot, frame);
  const double tick = style_.Px(kTickLength);
  for (const double at : x_ticks_.at) {
    const double x = std::round(scale_.ToX(at)) + 0.5;
    canvas_.Line({x, plot.bottom() + 0.5}, {x, plot.bottom() + tick}, frame);
  }
  for (std::size_t i = 0; i < y_ticks_.at.size(); ++i) {
    const double y = std::round(scale_.ToY(y_ticks_.at[i])) + 0.5;
    canvas_.Line({plot.left - tick, y}, {plot.left + 0.5, y}, frame);
    canvas_.Text(y_ticks_.labels[i],
                 plot.left - tick - style_.Px(5),
                 y,
                 style_.tick_px,
                 kTextColour,
                 Align::kRight);
  }
  canvas_.VerticalText(AxisText(panel_.y, y_ticks_.exponent),
                       y_label_x,
                       plot.top + 0.5 * plot.height,
                       style_.label_px,
                       kTextColour);
  DrawHead();
  DrawLevelLabels();
  if (panel_.inset) {
    DrawInset(*panel_.inset);
  }
}

std::vector<std::vector<PanelPainter::LegendEntry>> PanelPainter::LegendRows(int width) const {
  std::vector<std::vector<LegendEntry>> rows;
  int left = 0;
  const auto add = [&](LegendEntry entry) {
    entry.width = canvas_.TextWidth(entry.text, style_.legend_px) +
                  style_.Px(kSwatch + kSwatchGap + kEntryGap);
    if (rows.empty() || entry.width > left) {
      rows.emplace_back();
      const int title =
          rows.size() > 1 || panel_.title.empty()
              ? 0
              : canvas_.TextWidth(panel_.title, style_.label_px) + style_.Px(kEntryGap);
      left = width - title + style_.Px(kEntryGap);
    }
    left -= entry.width;
    rows.back().push_back(std::move(entry));
  };
  for (const Series& series : panel_.series) {
    if (!series.name.empty()) {
      add({series.name, &series, nullptr, 0});
    }
  }
  for (const Band& band : panel_.bands) {
    if (!band.name.empty()) {
      add({band.name, nullptr, &band, 0});
    }
  }
  return rows;
}

int PanelPainter::HeadHeight(int width) const {
  const std::size_t rows = LegendRows(width).size();
  const std::size_t lines = std::max<std::size_t>(rows, panel_.title.empty() ? 0 : 1);
  return lines == 0 ? style_.Px(12) : style_.Px(kLegendRow * static_cast<double>(lines) + 6);
}

void PanelPainter::DrawHead() {
  const PixelRect& plot = scale_.plot;
  const std::vector<std::vector<LegendEntry>> rows = LegendRows(plot.width);
  const double row_height = style_.Px(kLegendRow);
  double y = plot.top - style_.Px(4) - row_height * (static_cast<double>(rows.size()) - 0.5);
  if (!panel_.title.empty()) {
    const double title_y = rows.empty() ? plot.top - style_.Px(4) - 0.5 * row_height : y;
    canvas_.Text(panel_.title, plot.left, title_y, style_.label_px, kTextColour);
  }
  for (const std::vector<LegendEntry>& row : rows) {
    int row_width = -style_.Px(kEntryGap);
    for (const LegendEntry& entry : row) {
      row_width += entry.width;
    }
    double x = plot.right() - row_width;
    for (const LegendEntry& entry : row) {
      DrawLegendEntry(entry, x, y);
      x += entry.width;
    }
    y += row_height;
  }
}

void PanelPainter::DrawLegendEntry(const LegendEntry& entry, double x, double y) {
  const double swatch = style_.Px(kSwatch);
  if (entry.series != nullptr) {
    Stroke stroke = StrokeOf(*entry.series);
    stroke.width_px = std::max(stroke.width_px, style_.Px(2.2));
    canvas_.Line({x, y}, {x + swatch, y}, stroke);
  } else {
    const int height = style_.Px(16);
    const PixelRect box = {
        static_cast<int>(x), static_cast<int>(y) - height / 2, static_cast<int>(swatch), height};
    canvas_.Fill(box, Tint(ColourOf(entry.band->ink), 2 * kBandShare));
    canvas_.Frame(box, {Tint(ColourOf(entry.band->ink), 0.5), style_.line_px});
  }
  canvas_.Text(entry.text, x + swatch + style_.Px(kSwatchGap), y, style_.legend_px, kTextColour);
}

void PanelPainter::DrawLevelLabels() {
  std::vector<const Level*> shown;
  for (const Level& level : panel_.levels) {
    if (!level.label.empty() && level.y >= scale_.y.first && level.y <= scale_.y.second) {
      shown.push_back(&level);
    }
  }
  const auto higher = [](const Level* a, const Level* b) { return a->y > b->y; };
  std::ranges::sort(shown, higher);
  std::vector<double> places;
  for (const Level* level : shown) {
    places.push_back(scale_.ToY(level->y));
  }
  const double half = 0.5 * style_.legend_px;
  SpreadApart(places, 1.15 * style_.legend_px, scale_.plot.top + half, scale_.plot.bottom() - half);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    canvas_.Text(shown[i]->label,
                 scale_.plot.right() + style_.Px(kLabelGap),
                 places[i],
                 style_.legend_px,
                 ColourOf(shown[i]->ink));
  }
}

void PanelPainter::DrawInset(const Inset& inset) {
  const PixelRect& plot = scale_.plot;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Series& series : panel_.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (series.x[i] >= inset.x_from && series.x[i] <= inset.x_to && std::isfinite(series.y[i])) {
        low = std::min(low, series.y[i]);
        high = std::max(high, series.y[i]);
      }
    }
  }
  if (low > high) {
    return;
  }
  const double data_top = scale_.ToY(high);
  const double room = data_top - plot.top;  // the builder of the figure left it free above the data
  const PixelRect box = {plot.left + static_cast<int>(0.03 * plot.width),
                         plot.top + static_cast<int>(0.12 * room) + style_.inset_px,
                         static_cast<int>(0.44 * plot.width),
                         static_cast<int>(0.72 * room) - style_.inset_px};
  const Stroke thin = {kQuietColour, style_.line_px};
  const double x_from = scale_.ToX(inset.x_from);
  const double x_to = scale_.ToX(inset.x_to);
  const double data_bottom = scale_.ToY(low);
  const PixelRect source = {static_cast<int>(std::floor(x_from)),
                            static_cast<int>(std::floor(data_top)) - style_.Px(4),
                            static_cast<int>(std::ceil(x_to - x_from)),
                            static_cast<int>(std::ceil(data_bottom - data_top)) + style_.Px(8)};
  canvas_.Line({static_cast<double>(source.left), static_cast<double>(source.top)},
               {static_cast<double>(box.left), static_cast<double>(box.bottom())},
               thin);
  canvas_.Line({static_cast<double>(source.right()), static_cast<double>(source.top)},
               {static_cast<double>(box.right()), static_cast<double>(box.bottom())},
               thin);
  canvas_.Frame(source, {kTextColour, std::max(1, style_.Px(1.5))});
  canvas_.Fill(box, kPaper);
  PlotScale magnified = {box, {inset.x_from, inset.x_to}, WithMargin(low, high)};
  const double room_y = 0.12 * (high - low);
  magnified.y = {magnified.y.first - room_y, magnified.y.second + room_y};
  const Ticks ticks = MakeTicks(inset.x_from, inset.x_to, 8);
  for (std::size_t i = 0; i < ticks.at.size(); ++i) {
    const double x = std::round(magnified.ToX(ticks.at[i])) + 0.5;
    canvas_.Line({x, box.top + 0.5}, {x, box.bottom() + 0.5}, {kGridColour, style_.line_px});
    canvas_.Text(ticks.labels[i],
                 x,
                 box.top - 0.75 * style_.inset_px,
                 style_.inset_px,
                 kQuietColour,
                 Align::kCentre);
  }
  DrawSeriesOn(magnified, style_.Px(4));
  canvas_.Frame(box, thin);
}

}  // namespace faultlab::server
