#include "server/storage/rig_calibrations.h"

#include <soci/soci.h>

namespace faultlab::server {

using soci::into;
using soci::use;

core::Status RigCalibrations::Add(const RigCalibration& calibration) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) {
    const std::int64_t at_ms = ToMilliseconds(calibration.at);
    const int kept = kKept;
    const InputRange& input = calibration.input;
    tx.sql() << "INSERT INTO rig_calibration (run, rig, bench, at_ms, body, low_v, high_v, rms_v, "
                "unfit) VALUES (:run, :rig, :bench, :at, :body, :low, :high, :rms, :unfit)",
        use(calibration.run, "run"), use(calibration.rig, "rig"), use(calibration.bench, "bench"),
        use(at_ms, "at"), use(calibration.json, "body"), use(input.low_v, "low"),
        use(input.high_v, "high"), use(input.rms_v, "rms"), use(calibration.unfit, "unfit");
    tx.sql() << "DELETE FROM rig_calibration WHERE rig = :rig AND run NOT IN (SELECT run FROM "
                "rig_calibration WHERE rig = :same ORDER BY at_ms DESC, run LIMIT :kept)",
        use(calibration.rig, "rig"), use(calibration.rig, "same"), use(kept, "kept");
  });
}

core::Result<std::vector<RigCalibration>> RigCalibrations::List(const std::string& rig,
                                                                const std::string& bench,
                                                                int limit) {
  using Rows = std::vector<RigCalibration>;
  return database_.Read([&](Transaction& tx) {
    Rows rows;
    RigCalibration row;
    row.rig = rig;
    row.bench = bench;
    std::int64_t at_ms = 0;
    soci::statement query =
        (tx.sql().prepare << "SELECT c.run, c.at_ms, c.body, c.low_v, c.high_v, "
                             "c.rms_v, c.unfit, COALESCE(r.owner, '') "
                             "FROM rig_calibration c "
                             "LEFT JOIN recording r ON r.id = c.run "
                             "WHERE c.rig = :rig AND c.bench = :bench "
                             "ORDER BY c.at_ms DESC, c.run LIMIT :limit",
         into(row.run),
         into(at_ms),
         into(row.json),
         into(row.input.low_v),
         into(row.input.high_v),
         into(row.input.rms_v),
         into(row.unfit),
         into(row.owner),
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
