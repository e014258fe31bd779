#include "server/stream/row_history.h"

#include <algorithm>

#include "core/types/frame.h"

namespace faultlab::server {
namespace {

StreamRow AbsentRow() {
  StreamRow row{};
  row.values.fill(static_cast<float>(core::kAbsent));
  std::fill_n(row.statuses.begin(),
              core::kEstimatorCount,
              static_cast<std::uint8_t>(core::EstimateStatus::kInvalid));
  return row;
}

}  // namespace

void RowHistory::Append(std::int64_t first_index,
                        std::span<const StreamRow> rows,
                        std::size_t rows_max) {
  if (rows.empty()) return;
  const bool follows = !rows_.empty() && first_index >= next_ &&
                       first_index - next_ <= static_cast<std::int64_t>(rows_max);
  if (!follows) {
    rows_.clear();
    first_ = next_ = first_index;
  }
  rows_.insert(rows_.end(), static_cast<std::size_t>(first_index - next_), AbsentRow());
  rows_.insert(rows_.end(), rows.begin(), rows.end());
  next_ = first_index + static_cast<std::int64_t>(rows.size());
  if (rows_.size() <= rows_max) return;
  // Removes a tenth at a time, so that the copy is rare.
  const std::size_t excess = std::min(rows_.size(), rows_.size() - rows_max + rows_max / 10);
  rows_.erase(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(excess));
  first_ += static_cast<std::int64_t>(excess);
}

std::span<const StreamRow> RowHistory::From(std::int64_t from, std::int64_t count) const {
  return std::span<const StreamRow>(rows_).subspan(
      static_cast<std::size_t>(from - first_),
      static_cast<std::size_t>(std::min(count, next_ - from)));
}

}  // namespace faultlab::server
