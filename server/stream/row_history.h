#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/stream/frame_codec.h"

namespace faultlab::server {

/// The newest rows of a run, one for each index from first() up to next(): what a viewer that comes
/// late, or comes back, is sent.
class RowHistory {
 public:
  /// Rows that leave a hole of indices get absent rows before them; rows that go back in time, or
  /// jump further than `rows_max` ahead, start the history anew. Keeps at most `rows_max` rows.
  void Append(std::int64_t first_index, std::span<const StreamRow> rows, std::size_t rows_max);

  std::int64_t first() const { return first_; }
  std::int64_t next() const { return next_; }
  /// At most `count` rows from `from` on, which lies in [first(), next()].
  std::span<const StreamRow> From(std::int64_t from, std::int64_t count) const;

 private:
  std::vector<StreamRow> rows_;
  std::int64_t first_ = 0;
  std::int64_t next_ = 0;
};

}  // namespace faultlab::server
