#include "hardware/lcm/reorder_buffer.h"

#include <algorithm>
#include <utility>

#include "hardware/lcm/rig_codec.h"

namespace faultlab::hardware {

void ReorderBuffer::Begin(std::int64_t run, const core::Bench& bench) {
  run_ = run;
  bench_ = &bench;
  next_seq_ = end_seq_ = next_index_ = 0;
  early_.clear();
}

void ReorderBuffer::Expect(std::int64_t end_seq) {
  end_seq_ = std::max(end_seq_, end_seq);
}

void ReorderBuffer::Take(const faultlab_msgs::rig_stream_t& piece, std::vector<RigMessage>& out) {
  if (piece.run != run_) return;
  const std::int64_t end = piece.first_seq + piece.count;
  const bool refill = end <= end_seq_;
  Expect(end);
  for (std::int64_t seq = std::max(piece.first_seq, next_seq_); seq < end; ++seq) {
    const auto& item = piece.items[static_cast<std::size_t>(seq - piece.first_seq)];
    if (early_.emplace(seq, FromItem(item, *bench_)).second && refill) ++refilled_;
  }
  while (true) {
    GiveInOrder(out);
    if (next_seq_ >= piece.oldest_seq) return;
    // Gone from the agent's ring: the recording says so.
    const auto known = early_.begin();
    const std::int64_t to =
        known == early_.end() ? piece.oldest_seq : std::min(piece.oldest_seq, known->first);
    out.emplace_back(RigEvent{.kind = RigEventKind::kGap,
                              .index = next_index_,
                              .value = static_cast<double>(to - next_seq_),
                              .text = "lost on the way and no longer in the agent's ring"});
    next_seq_ = to;
  }
}

void ReorderBuffer::GiveInOrder(std::vector<RigMessage>& out) {
  for (auto next = early_.begin(); next != early_.end() && next->first == next_seq_;
       next = early_.erase(next), ++next_seq_) {
    if (const auto* sample = std::get_if<core::Sample>(&next->second)) {
      next_index_ = sample->index + 1;
    }
    out.push_back(std::move(next->second));
  }
}

std::vector<ReorderBuffer::Hole> ReorderBuffer::Holes(std::size_t max) const {
  std::vector<Hole> holes;
  std::int64_t from = next_seq_;
  auto known = early_.begin();
  while (holes.size() < max && from < end_seq_) {
    const std::int64_t to = known == early_.end() ? end_seq_ : known->first;
    if (to > from) holes.push_back({from, to});
    from = to;
    while (known != early_.end() && known->first == from) {
      ++known;
      ++from;
    }
  }
  return holes;
}

}  // namespace faultlab::hardware
