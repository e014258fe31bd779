#pragma once

#include "server/plots/canvas.h"
#include "server/plots/figure.h"
#include "server/plots/panel_painter.h"

namespace faultlab::server {

/// Cells with their text, row names on the left, column names above.
void DrawMatrix(Canvas& canvas,
                const PlotStyle& style,
                const CellMatrix& matrix,
                const PixelRect& area);

}  // namespace faultlab::server
