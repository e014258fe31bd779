#include "server/plots/matrix_painter.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

constexpr Rgb kFullColour = {0x00, 0x72, 0xB2};
constexpr Rgb kEmptyColour = {0xF2, 0xF2, 0xF2};
constexpr double kWhiteTextFrom = 0.55;  // share of the colour; above, black is unreadable

int WidestText(Canvas& canvas, const std::vector<std::string>& texts, int size_px) {
  int widest = 0;
  for (const std::string& text : texts) {
    widest = std::max(widest, canvas.TextWidth(text, size_px));
  }
  return widest;
}

/// The largest size not above `wanted` in which every text fits its cell.
int FittingSize(Canvas& canvas, const std::vector<std::string>& texts, int wanted, double room) {
  const int widest = WidestText(canvas, texts, wanted);
  const double shrink = widest > room ? room / widest : 1.0;
  return std::max(6, static_cast<int>(std::floor(wanted * shrink)));
}

}  // namespace

void DrawMatrix(Canvas& canvas,
                const PlotStyle& style,
                const CellMatrix& matrix,
                const PixelRect& area) {
  const std::size_t rows = matrix.rows.size();
  const std::size_t columns = matrix.columns.size();
  LAB_CHECK(matrix.value.size() == rows * columns && matrix.text.size() == rows * columns,
            rows,
            columns,
            matrix.value.size(),
            matrix.text.size());
  if (columns == 0) {
    return;
  }
  const int left = area.left + 2 * style.label_px + WidestText(canvas, matrix.rows, style.tick_px) +
                   style.Px(12);
  const int top = area.top + 2 * style.label_px + style.tick_px + style.Px(12);
  const double cell_width = static_cast<double>(area.right() - left) / static_cast<double>(columns);
  const double cell_height = static_cast<double>(area.bottom() - top) / static_cast<double>(rows);
  const int text_px = std::min(FittingSize(canvas, matrix.text, style.tick_px, 0.88 * cell_width),
                               static_cast<int>(0.6 * cell_height));
  const int column_px = FittingSize(canvas, matrix.columns, style.tick_px, 0.94 * cell_width);
  const auto edge_x = [&](std::size_t c) {
    return left + static_cast<int>(std::lround(cell_width * static_cast<double>(c)));
  };
  const auto edge_y = [&](std::size_t r) {
    return top + static_cast<int>(std::lround(cell_height * static_cast<double>(r)));
  };
  for (std::size_t r = 0; r < rows; ++r) {
    const double middle_y = 0.5 * (edge_y(r) + edge_y(r + 1));
    canvas.Text(
        matrix.rows[r], left - style.Px(10), middle_y, style.tick_px, kTextColour, Align::kRight);
    for (std::size_t c = 0; c < columns; ++c) {
      const double value = matrix.value[r * columns + c];
      const double share = std::isnan(value) ? 0.0 : std::clamp(value, 0.0, 1.0);
      const Rgb ground = std::isnan(value) ? kEmptyColour : Tint(kFullColour, 0.04 + 0.96 * share);
      canvas.Fill({edge_x(c) + style.line_px,
                   edge_y(r) + style.line_px,
                   edge_x(c + 1) - edge_x(c) - 2 * style.line_px,
                   edge_y(r + 1) - edge_y(r) - 2 * style.line_px},
                  ground);
      canvas.Text(matrix.text[r * columns + c],
                  0.5 * (edge_x(c) + edge_x(c + 1)),
                  middle_y,
                  text_px,
                  share > kWhiteTextFrom ? kPaper : kTextColour,
                  Align::kCentre);
    }
  }
  for (std::size_t c = 0; c < columns; ++c) {
    canvas.Text(matrix.columns[c],
                0.5 * (edge_x(c) + edge_x(c + 1)),
                top - 0.5 * style.tick_px - style.Px(8),
                column_px,
                kTextColour,
                Align::kCentre);
  }
  canvas.Text(matrix.column_title,
              0.5 * (left + area.right()),
              area.top + style.label_px,
              style.label_px,
              kTextColour,
              Align::kCentre);
  canvas.VerticalText(matrix.row_title,
                      area.left + 0.6 * style.label_px,
                      0.5 * (top + area.bottom()),
                      style.label_px,
                      kTextColour);
}

}  // namespace faultlab::server
