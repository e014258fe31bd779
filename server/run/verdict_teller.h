#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/types/verdict.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// The events of a diagnosis, "detected", "isolated" and "returned", from its verdicts in their
/// order: of a run while it goes on, and of one that was sealed when it is opened.
class VerdictTeller {
 public:
  explicit VerdictTeller(double period_s) : period_s_(period_s) {}

  /// What is new in this verdict, in order.
  /// @param now  index of the newest sample
  std::vector<RecordedEvent> Hear(const core::Verdict& verdict, std::int64_t now);
  /// The diagnosis begins anew: there is nothing to return from.
  void Restart();

 private:
  const double period_s_;
  std::optional<double> detected_at_s_;
  double told_s_ = -1.0;                   ///< of the newest "detected"
  std::vector<core::Component> isolated_;  ///< all that the newest "isolated" named
};

}  // namespace faultlab::server
