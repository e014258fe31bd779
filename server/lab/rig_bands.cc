#include "server/lab/rig_bands.h"

#include <soci/soci.h>

namespace faultlab::server::lab {

using soci::into;
using soci::use;

core::Result<std::optional<RigBand>> RigBands::Get(const std::string& rig) {
  using MaybeBand = std::optional<RigBand>;
  return database_.Read([&](Transaction& tx) -> core::Result<MaybeBand> {
    RigBand band;
    tx.sql() << "SELECT b0d, gain, a1d FROM rig_band WHERE rig = :rig", into(band.b0d),
        into(band.gain), into(band.a1d), use(rig, "rig");
    if (!tx.sql().got_data()) return MaybeBand{};
    return MaybeBand{band};
  });
}

core::Status RigBands::Put(const std::string& rig,
                           const RigBand& band,
                           const std::string& source,
                           WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "INSERT INTO rig_band (rig, b0d, gain, a1d, source, at_ms) "
                "VALUES (:rig, :b0d, :gain, :a1d, :source, :now) ON CONFLICT (rig) DO UPDATE SET "
                "b0d = excluded.b0d, gain = excluded.gain, a1d = excluded.a1d, "
                "source = excluded.source, at_ms = excluded.at_ms",
        use(rig, "rig"), use(band.b0d, "b0d"), use(band.gain, "gain"), use(band.a1d, "a1d"),
        use(source, "source"), use(now_ms, "now");
  });
}

core::Status RigBands::Forget(const std::string& rig) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    tx.sql() << "DELETE FROM rig_band WHERE rig = :rig", use(rig, "rig");
  });
}

}  // namespace faultlab::server::lab
