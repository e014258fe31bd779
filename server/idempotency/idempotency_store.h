#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// Answers by (owner, Idempotency-Key), kept for a day; of each owner the newest, within the
/// limits. Thread-safe, stateless.
class IdempotencyStore {
 public:
  static constexpr int kOfOwnerMax = 1000;
  static constexpr std::int64_t kLettersOfOwnerMax = 4 << 20;  ///< total size of stored bodies

  explicit IdempotencyStore(Database& database) : database_(database) {}

  struct Answer {
    int status = 0;
    std::string body;
  };
  /// The answer to the same request before, or nullopt: execute the request, then call Finish or
  /// Forget. kConflict: a different request had this key. kBusy: the first request is still
  /// executing; after ten minutes without an end it counts as dead (the server crashed) and may be
  /// executed again.
  core::Result<std::optional<Answer>> Begin(const std::string& owner,
                                            const std::string& key,
                                            const std::string& request_hash,
                                            WallTime now);
  core::Status Finish(const std::string& owner,
                      const std::string& key,
                      int status,
                      const std::string& body);
  core::Status Forget(const std::string& owner, const std::string& key);

 private:
  Database& database_;
};

}  // namespace faultlab::server
