#include "hardware/lcm/retransmit_buffer.h"

#include <algorithm>

#include "hardware/lcm/channels.h"
#include "hardware/lcm/rig_codec.h"

namespace faultlab::hardware {

void RetransmitBuffer::Begin() {
  items_.clear();
  first_seq_ = 0;
}

void RetransmitBuffer::Push(const RigMessage& message) {
  items_.push_back(ToItem(message));
  if (items_.size() <= items_max_) return;
  items_.pop_front();
  ++first_seq_;
}

std::vector<faultlab_msgs::rig_stream_t> RetransmitBuffer::Pieces(std::int64_t from,
                                                                  std::int64_t to) const {
  from = std::clamp(from, first_seq_, next_seq());
  to = std::clamp(to, from, std::min(next_seq(), from + kRefillItemsMax));
  std::vector<faultlab_msgs::rig_stream_t> pieces;
  do {
    const std::int64_t end = std::min<std::int64_t>(from + kRefillItems, to);
    pieces.push_back(Piece(from, end));
    from = end;
  } while (from < to);
  return pieces;
}

faultlab_msgs::rig_stream_t RetransmitBuffer::PieceOf(std::int64_t from, std::size_t bytes) const {
  from = std::max(from, first_seq_);
  std::int64_t end = from;
  std::size_t used = 0;
  while (end < next_seq()) {
    const auto& item = items_[static_cast<std::size_t>(end - first_seq_)];
    used += static_cast<std::size_t>(item._getEncodedSizeNoHash());
    if (used > bytes && end > from) break;
    ++end;
  }
  return Piece(from, end);
}

faultlab_msgs::rig_stream_t RetransmitBuffer::Piece(std::int64_t from, std::int64_t end) const {
  faultlab_msgs::rig_stream_t piece;
  piece.first_seq = from;
  piece.oldest_seq = first_seq_;
  piece.items.assign(items_.begin() + (from - first_seq_), items_.begin() + (end - first_seq_));
  piece.count = static_cast<std::int32_t>(piece.items.size());
  return piece;
}

}  // namespace faultlab::hardware
