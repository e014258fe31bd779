#pragma once

#include <vector>

#include "server/plots/canvas.h"
#include "server/plots/figure.h"
#include "server/plots/mark_labels.h"
#include "server/plots/panel_painter.h"

namespace faultlab::server {

/// The vertical line of each mark through one panel.
void DrawMarkLines(Canvas& canvas,
                   const PlotStyle& style,
                   const std::vector<Mark>& marks,
                   const PlotScale& scale);

/// The marks that the plot shows, with the places of their labels.
class MarkLane {
 public:
  MarkLane(Canvas& canvas,
           const PlotStyle& style,
           const std::vector<Mark>& marks,
           const PlotScale& scale);

  int rows() const { return RowsOf(labels_); }
  /// Symbol and label of each mark; `bottom_y` is the middle of the lowest row.
  void Draw(double bottom_y, double row_height) const;

 private:
  Canvas& canvas_;
  const PlotStyle& style_;
  const PlotScale& scale_;
  std::vector<Mark> marks_;
  std::vector<MarkLabel> labels_;
};

}  // namespace faultlab::server
