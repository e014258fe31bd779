#include "server/experiment/storage_quota.h"

#include <filesystem>

#include "server/run/refusals.h"

namespace faultlab::server {

core::Status StorageQuota::CheckDisk() const {
  if (limits_.disk_reserve_bytes == 0 || limits_.folder.empty()) return core::Done{};
  std::error_code ec;
  const auto space = std::filesystem::space(limits_.folder, ec);
  // A disk that does not say how full it is fails where it is written to.
  if (ec || space.available > static_cast<std::uintmax_t>(limits_.disk_reserve_bytes)) {
    return core::Done{};
  }
  return refusal::DiskFull();
}

core::Status StorageQuota::MakeRoom(const Principal& who, std::int64_t samples) {
  const core::Status disk = CheckDisk();
  if (!disk.ok()) return disk;
  const std::int64_t limit = LimitOf(who);
  if (limit == 0) return core::Done{};
  const std::string owner = who.owner_key();
  auto kept = store_.SamplesOf(owner);
  if (!kept) return kept.error();
  while (kept.value() + samples > limit) {
    if (who.signed_in() || samples > limit) return refusal::QuotaFull(kept.value(), limit);
    const auto oldest = store_.OldestEndedOf(owner);
    if (!oldest) return oldest.error();
    if (!oldest.value()) return refusal::QuotaFull(kept.value(), limit);
    const core::Status deleted = store_.Delete(*oldest.value());
    const bool gone =
        deleted.ok() || deleted.error().code == core::ErrorCode::kNotFound;  // by another guest
    if (!gone) return deleted;
    kept = store_.SamplesOf(owner);
    if (!kept) return kept.error();
  }
  return core::Done{};
}

core::Result<StorageQuota::Usage> StorageQuota::Of(const Principal& who) {
  const auto kept = store_.SamplesOf(who.owner_key());
  if (!kept) return kept.error();
  return Usage{kept.value(), LimitOf(who)};
}

}  // namespace faultlab::server
