#include "server/run/rig_tally.h"

#include <utility>

namespace faultlab::server {

void RigTally::Closed(const std::string& rig, int line) {
  const std::lock_guard lock(mutex_);
  ++taken_.closings[rig][line];
}

void RigTally::Tell(News news) {
  const std::lock_guard lock(mutex_);
  if (taken_.news.size() < kNewsMax) taken_.news.push_back(std::move(news));
}

RigTally::Taken RigTally::Take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(taken_, {});
}

}  // namespace faultlab::server
