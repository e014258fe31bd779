#include "server/plots/marks_painter.h"

#include <algorithm>

namespace faultlab::server {
namespace {

constexpr Rgb kFaultColour = {0xB3, 0x00, 0x1B};
constexpr Rgb kDetectColour = {0x00, 0x5A, 0x8F};
constexpr double kSymbol = 7;  // half size
constexpr double kGap = 8;
constexpr double kEdge = 4;  // right of the labels
constexpr int kRowsMax = 4;

Rgb ColourOf(MarkKind kind) {
  return kind == MarkKind::kFault ? kFaultColour : kDetectColour;
}

Dash DashOf(MarkKind kind) {
  if (kind == MarkKind::kFault) return Dash::kSolid;
  return kind == MarkKind::kDetected ? Dash::kDashed : Dash::kDotted;
}

void DrawSymbol(Canvas& canvas, MarkKind kind, double x, double y, double half) {
  const Rgb colour = ColourOf(kind);
  switch (kind) {
    case MarkKind::kFault: {
      const PixelPoint down[] = {{x - half, y - half}, {x + half, y - half}, {x, y + half}};
      canvas.Polygon(down, colour);
      break;
    }
    case MarkKind::kDetected: {
      const double tip = 1.2 * half;
      const PixelPoint diamond[] = {{x, y - tip}, {x + tip, y}, {x, y + tip}, {x - tip, y}};
      canvas.Polygon(diamond, colour);
      break;
    }
    case MarkKind::kReturned: {
      const PixelPoint up[] = {{x - half, y + half}, {x + half, y + half}, {x, y - half}};
      canvas.Polygon(up, colour);
      break;
    }
  }
}

std::vector<Mark> InOrder(const std::vector<Mark>& marks, const PlotScale& scale) {
  std::vector<Mark> shown;
  for (const Mark& mark : marks) {
    if (mark.x >= scale.x.first && mark.x <= scale.x.second) {
      shown.push_back(mark);
    }
  }
  std::ranges::stable_sort(shown, {}, &Mark::x);
  return shown;
}

}  // namespace

void DrawMarkLines(Canvas& canvas,
                   const PlotStyle& style,
                   const std::vector<Mark>& marks,
                   const PlotScale& scale) {
  for (const Mark& mark : InOrder(marks, scale)) {
    const double x = scale.ToX(mark.x);
    canvas.Line({x, static_cast<double>(scale.plot.top)},
                {x, static_cast<double>(scale.plot.bottom())},
                {ColourOf(mark.kind),
                 std::max(1, style.Px(1.6)),
                 DashOf(mark.kind),
                 static_cast<double>(style.Px(4))});
  }
}

MarkLane::MarkLane(Canvas& canvas,
                   const PlotStyle& style,
                   const std::vector<Mark>& marks,
                   const PlotScale& scale)
    : canvas_(canvas), style_(style), scale_(scale), marks_(InOrder(marks, scale)) {
  std::vector<MarkPlace> places;
  for (const Mark& mark : marks_) {
    const double text = canvas.TextWidth(mark.label, style.legend_px);
    const double symbol = 2 * style.Px(kSymbol);
    places.push_back({scale.ToX(mark.x), symbol + style.Px(kGap) + text, symbol});
  }
  labels_ = PlaceMarkLabels(places,
                            {.left = static_cast<double>(scale.plot.left),
                             .right = static_cast<double>(canvas.width() - style.Px(kEdge)),
                             .gap = 2.0 * style.Px(kGap),
                             .rows_max = kRowsMax});
}

void MarkLane::Draw(double bottom_y, double row_height) const {
  const double half = style_.Px(kSymbol);
  const double gap = style_.Px(kGap);
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const Mark& mark = marks_[i];
    const MarkLabel& label = labels_[i];
    if (label.shown == MarkLabel::Shown::kNothing) continue;
    const double y = bottom_y - label.row * row_height;
    const double line = scale_.ToX(mark.x);
    DrawSymbol(canvas_, mark.kind, label.on_left ? line - half : line + half, y, half);
    if (label.shown == MarkLabel::Shown::kSymbol) continue;
    const double text = label.on_left ? label.start : line + 2 * half + gap;
    canvas_.Text(mark.label, text, y, style_.legend_px, ColourOf(mark.kind));
  }
}

}  // namespace faultlab::server
