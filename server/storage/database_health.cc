#include "server/storage/database_health.h"

#include <soci/soci.h>

#include <chrono>

#include "server/storage/rows.h"

namespace faultlab::server {

core::Status DatabaseHealth::Check() {
  {
    const std::lock_guard lock(mutex_);
    const bool fresh = asked_ && clock_.Monotonic() - *asked_ < std::chrono::seconds(1);
    if (fresh || asking_) return last_;
    asking_ = true;
  }
  const core::Status now = database_.Write(Durability::kTelemetry, [](Transaction& tx) {
    Execute(tx,
            "UPDATE schema_version SET description = description "
            "WHERE version = (SELECT MIN(version) FROM schema_version)");
  });
  const std::lock_guard lock(mutex_);
  asked_ = clock_.Monotonic();
  asking_ = false;
  last_ = now;
  return now;
}

}  // namespace faultlab::server
