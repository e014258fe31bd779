#include "server/storage/rig_calibrations.h"

#include <soci/soci.h>

namespace faultlab::server {

using soci::into;
using soci::use;

core::Status RigCalibrations::Add(const RigCalibration& calibration) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) -> core::Status {
    const std::int64_t at_ms = ToMilliseconds(calibration.at);
    const int kept = kKept;
    tx.sql() << "INSERT INTO rig_calibration (run, rig, bench, at_ms, body) "
                "VALUES (:run, :rig, :bench, :at, :body)",
        use(calibration.run, "run"), use(calibration.rig, "rig"), use(calibration.bench, "bench"),
        use(at_ms, "at"), use(calibration.json, "body");
    tx.sql() << "DELETE FROM rig_calibration WHERE rig = :rig AND run NOT IN (SELECT run FROM "
                "rig_calibration WHERE rig = :same ORDER BY at_ms DESC, run LIMIT :kept)",
        use(calibration.rig, "rig"), use(calibration.rig, "same"), use(kept, "kept");
    return core::Done{};
  });
}

core::Result<std::vector<RigCalibration>> RigCalibrations::List(const std::string& rig,
                                                                const std::string& bench,
                                                                int limit) {
  using Rows = std::vector<RigCalibration>;
  return database_.Read([&](Transaction& tx) -> core::Result<Rows> {
    Rows rows;
    RigCalibration row{.rig = rig, .run = {}, .bench = bench, .at = {}, .json = {}};
    std::int64_t at_ms = 0;
    soci::statement query = (tx.sql().prepare << "SELECT run, at_ms, body FROM rig_calibration "
                                                 "WHERE rig = :rig AND bench = :bench "
                                                 "ORDER BY at_ms DESC, run LIMIT :limit",
                             into(row.run),
                             into(at_ms),
                             into(row.json),
                             use(rig, "rig"),
                             use(bench, "bench"),
                             use(limit, "limit"));
    query.execute();
    while (query.fetch()) {
      row.at = FromMilliseconds(at_ms);
      rows.push_back(row);
    }
    return rows;
  });
}

}  // namespace faultlab::server
