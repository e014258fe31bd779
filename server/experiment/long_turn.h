#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "core/types/result.h"

namespace faultlab::server {

/// Who holds a long recording in memory, or the long text of one: one at a time, so that many who
/// ask for such at once need no more memory than one. Short ones need no turn. Thread-safe; holds
/// may outlive it.
class LongTurn {
 public:
  /// Gives the turn back at its end. Empty for a short one.
  using Hold = std::shared_ptr<void>;
  enum class WhenTaken { kRefuse, kWait };

  static constexpr std::int64_t kShortSamplesMax = 200'000;  ///< 33 min at 100 Hz
  static constexpr std::size_t kShortTextBytesMax = 16 << 20;

  core::Result<Hold> ForSamples(std::int64_t samples, WhenTaken when_taken);
  core::Result<Hold> ForText(std::size_t bytes);

 private:
  struct State {
    std::mutex mutex;
    std::condition_variable returned;
    bool taken = false;
  };
  core::Result<Hold> Take(WhenTaken when_taken);

  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace faultlab::server
