#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "faultlab_msgs/rig_item_t.hpp"
#include "faultlab_msgs/rig_stream_t.hpp"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// The newest messages of a run, numbered, for those who missed some.
class RetransmitBuffer {
 public:
  explicit RetransmitBuffer(std::size_t items_max) : items_max_(items_max) {}

  /// Empty, numbers from 0.
  void Begin();
  void Push(const RigMessage& message);

  std::int64_t oldest_seq() const { return first_seq_; }
  std::int64_t next_seq() const { return first_seq_ + static_cast<std::int64_t>(items_.size()); }

  /// Pieces of at most kRefillItems for [from, to), as far as the ring goes back, at most
  /// kRefillItemsMax in all. Nothing to give is one empty piece: it carries the oldest there is.
  /// Whose run it is, is the caller's to fill in.
  std::vector<faultlab_msgs::rig_stream_t> Pieces(std::int64_t from, std::int64_t to) const;
  /// One piece of what fits into `bytes`, at least one item. Contract: from < next_seq().
  faultlab_msgs::rig_stream_t PieceOf(std::int64_t from, std::size_t bytes) const;

 private:
  faultlab_msgs::rig_stream_t Piece(std::int64_t from, std::int64_t end) const;

  const std::size_t items_max_;
  std::deque<faultlab_msgs::rig_item_t> items_;
  std::int64_t first_seq_ = 0;
};

}  // namespace faultlab::hardware
