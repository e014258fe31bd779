#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "faultlab_msgs/rig_stream_t.hpp"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Puts a run together from pieces that come late, twice, in any order or not at all: messages
/// leave by their sequence number, holes are known so that they can be asked for again.
class ReorderBuffer {
 public:
  struct Hole {
    std::int64_t from = 0;
    std::int64_t to = 0;  ///< one past the last
  };

  /// Forgets the run before; pieces of other runs are not taken. `bench` names the components.
  void Begin(std::int64_t run, const core::Bench& bench);
  std::int64_t run() const { return run_; }
  /// The run has messages up to here, says the agent.
  void Expect(std::int64_t end_seq);
  /// Appends to `out` what is in order now. What the agent no longer has becomes a kGap.
  void Take(const faultlab_msgs::rig_stream_t& piece, std::vector<RigMessage>& out);

  bool whole() const { return next_seq_ >= end_seq_; }
  std::vector<Hole> Holes(std::size_t max) const;
  std::int64_t next_index() const { return next_index_; }  ///< of the sample after the last given
  std::int64_t refilled() const { return refilled_; }      ///< messages that came by refill, ever

 private:
  void GiveInOrder(std::vector<RigMessage>& out);

  std::int64_t run_ = -1;
  const core::Bench* bench_ = nullptr;
  std::int64_t next_seq_ = 0;
  std::int64_t end_seq_ = 0;  ///< one past the highest that we know of
  std::int64_t next_index_ = 0;
  std::map<std::int64_t, RigMessage> early_;
  std::int64_t refilled_ = 0;
};

}  // namespace faultlab::hardware
