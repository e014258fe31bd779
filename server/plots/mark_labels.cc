#include "server/plots/mark_labels.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace faultlab::server {
namespace {

using Row = std::vector<std::pair<double, double>>;

bool IsFree(const Row& row, double start, double end, const LabelRoom& room) {
  if (start < room.left || end > room.right) return false;
  return std::ranges::none_of(row, [&](const auto& taken) {
    return start < taken.second + room.gap && end + room.gap > taken.first;
  });
}

/// If the next mark is close, left of the line where there is room, so that both fit in one row.
std::optional<MarkLabel> Take(
    std::vector<Row>& rows, double line, double length, bool crowded, const LabelRoom& room) {
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (const bool on_left : {crowded, !crowded}) {
      const double start = on_left ? line - length : line;
      if (!IsFree(rows[row], start, start + length, room)) continue;
      // Another label may begin right of the same line.
      rows[row].emplace_back(start, on_left ? line - room.gap : line + length);
      return MarkLabel{start, static_cast<int>(row), on_left, MarkLabel::Shown::kAll};
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<MarkLabel> PlaceMarkLabels(std::span<const MarkPlace> marks, const LabelRoom& room) {
  std::vector<Row> rows(static_cast<std::size_t>(std::max(1, room.rows_max)));
  std::vector<MarkLabel> labels;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const MarkPlace& mark = marks[i];
    const bool crowded =
        i + 1 < marks.size() && marks[i + 1].line < mark.line + mark.length + room.gap;
    auto label = Take(rows, mark.line, mark.length, crowded, room);
    if (!label) {
      label = Take(rows, mark.line, mark.symbol, false, room);
      if (label) label->shown = MarkLabel::Shown::kSymbol;
    }
    labels.push_back(label.value_or(MarkLabel{mark.line, 0, false, MarkLabel::Shown::kNothing}));
  }
  return labels;
}

int RowsOf(std::span<const MarkLabel> labels) {
  int rows = 1;
  for (const MarkLabel& label : labels) rows = std::max(rows, label.row + 1);
  return rows;
}

}  // namespace faultlab::server
