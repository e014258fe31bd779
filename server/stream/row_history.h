#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/stream/frame_codec.h"

namespace faultlab::server {

/// The newest rows of a run, one for each index from first() up to next(), for viewers that come
/// late or come back.
class RowHistory {
 public:
  /// If rows leave a gap of indices, absent rows are put before them. If they go back in time, or
  /// jump further than `rows_max` ahead, the history starts anew. Keeps at most `rows_max` rows.
  void Append(std::int64_t first_index, std::span<const StreamRow> rows, std::size_t rows_max);

  std::int64_t first() const { return first_; }
  std::int64_t next() const { return next_; }
  /// At most `count` rows beginning with `from`, which lies in [first(), next()].
  std::span<const StreamRow> From(std::int64_t from, std::int64_t count) const;

 private:
  std::vector<StreamRow> rows_;
  std::int64_t first_ = 0;
  std::int64_t next_ = 0;
};

}  // namespace faultlab::server
