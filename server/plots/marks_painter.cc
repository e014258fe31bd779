#include "server/plots/marks_painter.h"

#include <algorithm>

namespace faultlab::server {
namespace {

constexpr Rgb kFaultColour = {0xB3, 0x00, 0x1B};
constexpr Rgb kDetectColour = {0x00, 0x5A, 0x8F};
constexpr double kSymbol = 7;  // half size
constexpr double kGap = 8;

Rgb ColourOf(MarkKind kind) {
  switch (kind) {
    case MarkKind::kFault:
      return kFaultColour;
    case MarkKind::kDetected:
    case MarkKind::kIsolated:
    case MarkKind::kReturned:
      return kDetectColour;
  }
  return {};
}

Dash DashOf(MarkKind kind) {
  switch (kind) {
    case MarkKind::kFault:
      return Dash::kSolid;
    case MarkKind::kDetected:
      return Dash::kDashed;
    case MarkKind::kIsolated:
    case MarkKind::kReturned:
      return Dash::kDotted;
  }
  return Dash::kSolid;
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
    case MarkKind::kIsolated:
      canvas.Disc({x, y}, half, colour);
      break;
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
  std::stable_sort(
      shown.begin(), shown.end(), [](const Mark& a, const Mark& b) { return a.x < b.x; });
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

void DrawMarkLabels(Canvas& canvas,
                    const PlotStyle& style,
                    const std::vector<Mark>& marks,
                    const PlotScale& scale,
                    double y) {
  const std::vector<Mark> shown = InOrder(marks, scale);
  const double half = style.Px(kSymbol);
  const double gap = style.Px(kGap);
  double taken = scale.plot.left;  // the space left of it is occupied
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const Mark& mark = shown[i];
    const double line = scale.ToX(mark.x);
    const double width = 2 * half + gap + canvas.TextWidth(mark.label, style.legend_px);
    const bool crowded = i + 1 < shown.size() && scale.ToX(shown[i + 1].x) < line + width + 2 * gap;
    // If two marks are close, the label of the first is left of its line, with the symbol at the
    // line.
    const bool to_the_left = crowded && line - width - gap > taken;
    const double start = to_the_left ? line - width : std::max(line, taken);
    if (to_the_left) {
      canvas.Text(mark.label, start, y, style.legend_px, ColourOf(mark.kind));
      DrawSymbol(canvas, mark.kind, line - half, y, half);
    } else {
      DrawSymbol(canvas, mark.kind, start + half, y, half);
      canvas.Text(mark.label, start + 2 * half + gap, y, style.legend_px, ColourOf(mark.kind));
    }
    taken = start + width + 3 * gap;
  }
}

}  // namespace faultlab::server
