#include "server/storage/database_health.h"

#include <soci/soci.h>

#include <chrono>

namespace faultlab::server {

core::Status DatabaseHealth::Check() {
  const std::lock_guard lock(mutex_);
  const MonotonicTime now = clock_.Monotonic();
  if (asked_ && now - *asked_ < std::chrono::seconds(1)) return last_;
  last_ = database_.Write(Durability::kTelemetry, [](Transaction& tx) -> core::Status {
    tx.sql() << "UPDATE schema_version SET description = description WHERE version = 1";
    return core::Done{};
  });
  asked_ = clock_.Monotonic();
  return last_;
}

}  // namespace faultlab::server
