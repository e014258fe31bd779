#pragma once

#include <span>
#include <vector>

namespace faultlab::server {

/// A mark's line, and the lengths of its symbol with text and of its symbol; pixels.
struct MarkPlace {
  double line = 0.0;
  double length = 0.0;
  double symbol = 0.0;
};

/// Where symbol and text of a mark go. A symbol is beside its line.
struct MarkLabel {
  double start = 0.0;
  int row = 0;           ///< 0 is the lowest
  bool on_left = false;  ///< of its line, which the symbol then follows
  /// What there is room for.
  enum class Shown { kAll, kSymbol, kNothing } shown = Shown::kAll;
};

/// What is free for labels: all rows reach from `left` to `right`.
struct LabelRoom {
  double left = 0.0;
  double right = 0.0;
  double gap = 0.0;  ///< between two labels
  int rows_max = 1;
};

/// Places the labels so that none overlaps another or ends outside the room. Marks in order of
/// their lines.
std::vector<MarkLabel> PlaceMarkLabels(std::span<const MarkPlace> marks, const LabelRoom& room);

/// At least 1.
int RowsOf(std::span<const MarkLabel> labels);

}  // namespace faultlab::server
