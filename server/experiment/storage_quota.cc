#include "server/experiment/storage_quota.h"

#include <algorithm>

namespace faultlab::server {

core::Status StorageQuota::MakeRoom(const Principal& who, std::int64_t samples) {
  TRY_DONE(limits_.disk.Check());
  const std::int64_t limit = LimitOf(who);
  if (limit == 0) return core::Done{};
  const std::string owner = who.owner_key();
  samples = std::max(samples, RecordingStore::kSamplesLeast);
  auto kept = store_.SamplesOf(owner);
  if (!kept) return kept.error();
  while (kept.value() + samples > limit) {
    if (who.signed_in() || samples > limit)
      return core::Refuse("quota_full", "", {{"kept", kept.value()}, {"most", limit}});
    TRY(const auto oldest, store_.OldestEndedOf(owner));
    if (!oldest) return core::Refuse("quota_full", "", {{"kept", kept.value()}, {"most", limit}});
    const core::Status deleted = store_.Delete(*oldest);
    const bool gone =
        deleted.ok() || deleted.error().code == core::ErrorCode::kNotFound;  // by another guest
    if (!gone) return deleted;
    kept = store_.SamplesOf(owner);
    if (!kept) return kept.error();
  }
  return core::Done{};
}

core::Result<StorageQuota::Usage> StorageQuota::Of(const Principal& who) {
  TRY(const auto kept, store_.SamplesOf(who.owner_key()));
  TRY(const auto jobs, jobs_.BodyBytesOf(who.owner_key()));
  return Usage{kept, LimitOf(who), jobs};
}

}  // namespace faultlab::server
