#pragma once

#include <vector>

#include "server/plots/canvas.h"
#include "server/plots/figure.h"
#include "server/plots/panel_painter.h"

namespace faultlab::server {

/// The vertical line of each mark through one panel.
void DrawMarkLines(Canvas& canvas,
                   const PlotStyle& style,
                   const std::vector<Mark>& marks,
                   const PlotScale& scale);

/// Symbol and label of each mark in a strip whose middle is `y`; labels do not overlap.
void DrawMarkLabels(Canvas& canvas,
                    const PlotStyle& style,
                    const std::vector<Mark>& marks,
                    const PlotScale& scale,
                    double y);

}  // namespace faultlab::server
