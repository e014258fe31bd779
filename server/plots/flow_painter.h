#pragma once

#include <vector>

#include "server/plots/canvas.h"
#include "server/plots/figure.h"
#include "server/plots/panel_painter.h"

namespace faultlab::server {

/// A flow chart from left to right: a column for each further step, a row for each end.
/// Contract: each step but the first follows one other, and none itself.
void DrawFlow(Canvas& canvas,
              const PlotStyle& style,
              const std::vector<FlowStep>& steps,
              const PixelRect& area);

}  // namespace faultlab::server
