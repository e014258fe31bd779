#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// The messages of a whole run.
struct RunLog {
  std::vector<core::Sample> samples;
  std::vector<RigEvent> events;

  /// Events of one kind, in order.
  std::vector<RigEvent> Of(RigEventKind kind) const {
    std::vector<RigEvent> found;
    for (const RigEvent& event : events) {
      if (event.kind == kind) found.push_back(event);
    }
    return found;
  }
  std::string last_text() const { return events.empty() ? "" : events.back().text; }
};

/// Reads a started rig to its end. `on_sample` is called for each sample as it is read.
inline RunLog Drain(Rig& rig, const std::function<void(const core::Sample&)>& on_sample = {}) {
  RunLog log;
  std::vector<RigMessage> messages;
  ReadStatus status = ReadStatus::kMore;
  while (status == ReadStatus::kMore) {
    messages.clear();
    status = rig.Read(messages, std::chrono::milliseconds(100));
    for (RigMessage& message : messages) {
      if (auto* sample = std::get_if<core::Sample>(&message)) {
        log.samples.push_back(*sample);
        if (on_sample) on_sample(*sample);
      } else {
        log.events.push_back(std::get<RigEvent>(message));
      }
    }
  }
  return log;
}

/// A square wave between 2 V and 3 V: it moves every quantity visibly.
inline RunPlan SquarePlan(int samples) {
  RunPlan plan;
  for (int k = 0; k < samples; ++k) plan.uc_v.push_back((k / 7) % 2 == 0 ? 3.0 : 2.0);
  return plan;
}

}  // namespace faultlab::hardware
