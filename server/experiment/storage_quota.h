#pragma once

#include <cstdint>

#include "core/types/result.h"
#include "server/auth/principal.h"
#include "server/disk_reserve.h"
#include "server/jobs/job_store.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

struct StorageLimits {
  std::int64_t samples_per_account = 20'000'000;  ///< 55 h at 100 Hz, about 600 MB; 0: no limit
  std::int64_t samples_of_guests = 10'000'000;    ///< of all guests together; 0: no limit
  DiskReserve disk{};
};

/// How much each owner may keep, and what nobody may fill.
class StorageQuota {
 public:
  /// The stores must outlive it.
  StorageQuota(RecordingStore& store, JobStore& jobs, StorageLimits limits)
      : store_(store), jobs_(jobs), limits_(std::move(limits)) {}

  /// May this person record so many samples more? Guests are one owner: their oldest recordings
  /// make room. kConflict "quota_full", kUnavailable "disk_full".
  core::Status MakeRoom(const Principal& who, std::int64_t samples);

  struct Usage {
    std::int64_t samples = 0;
    std::int64_t samples_max = 0;  ///< 0: no limit
    std::int64_t job_bytes = 0;    ///< of jobs that wait or run; at most JobStore::kBodyBytesMax
  };
  core::Result<Usage> Of(const Principal& who);

 private:
  std::int64_t LimitOf(const Principal& who) const {
    return who.signed_in() ? limits_.samples_per_account : limits_.samples_of_guests;
  }

  RecordingStore& store_;
  JobStore& jobs_;
  const StorageLimits limits_;
};

}  // namespace faultlab::server
