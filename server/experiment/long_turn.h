#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/types/result.h"

namespace faultlab::server {

/// Who holds a long recording in memory, or the long text of one: one person, one job and one trial
/// that is graded at a time, so that many who ask for such at once need no more memory than three,
/// and no job keeps a person waiting. Short ones need no turn. Thread-safe; holds may outlive it.
class LongTurn {
 public:
  /// Gives the turn back at its end. Empty for a short one.
  using Hold = std::shared_ptr<void>;
  enum class For { kPerson, kJob, kGrading };

  /// The largest that need no turn.
  struct Short {
    std::int64_t samples;
    std::size_t text_bytes;
  };
  explicit LongTurn(Short limit) : limit_(limit) {}
  const Short& limit() const { return limit_; }

  /// kUnavailable kTaken while another has it; grading waits. A text is a person's.
  core::Result<Hold> ForText(std::size_t bytes);
  core::Result<Hold> ForSamples(std::int64_t samples, For whom);
  bool IsTaken(For whom) const;

  static constexpr const char* kTaken = "long_recording_waits";

 private:
  using Taken = std::atomic<bool>;
  core::Result<Hold> Take(For whom);
  const std::shared_ptr<Taken>& Of(For whom) const { return of_[static_cast<std::size_t>(whom)]; }

  const Short limit_;
  const std::array<std::shared_ptr<Taken>, 3> of_{std::make_shared<Taken>(false),
                                                  std::make_shared<Taken>(false),
                                                  std::make_shared<Taken>(false)};
};

}  // namespace faultlab::server
