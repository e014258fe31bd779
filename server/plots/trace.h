#pragma once

#include <utility>
#include <vector>

#include "server/plots/canvas.h"
#include "server/plots/figure.h"

namespace faultlab::server {

/// The map from values to pixels: x to the right, y upward inside `plot`.
struct PlotScale {
  PixelRect plot;
  std::pair<double, double> x;
  std::pair<double, double> y;

  double ToX(double value) const {
    return plot.left + (value - x.first) / (x.second - x.first) * plot.width;
  }
  double ToY(double value) const {
    return plot.bottom() - (value - y.first) / (y.second - y.first) * plot.height;
  }
};

/// The unbroken stretches of a series as pixels; NaN breaks the line, a stair gets its corners. If
/// more than four points share a pixel column, only its first, lowest, highest and last are kept,
/// so that no peak is lost.
std::vector<std::vector<PixelPoint>> MakeTraces(const Series& series, const PlotScale& scale);

}  // namespace faultlab::server
