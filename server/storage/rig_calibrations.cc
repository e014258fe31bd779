#include "server/storage/rig_calibrations.h"

#include "server/storage/rows.h"

namespace faultlab::server {

template <typename Visit>
void Fields(RigCalibration& of, Visit&& visit) {
  visit("run", of.run);
  visit("rig", of.rig);
  visit("bench", of.bench);
  visit("at_ms", of.at);
  visit("body", of.json);
  visit("low_v", of.input.low_v);
  visit("high_v", of.input.high_v);
  visit("rms_v", of.input.rms_v);
  visit("unfit", of.unfit);
}

core::Status RigCalibrations::Add(const RigCalibration& calibration) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) {
    InsertRow(tx, "rig_calibration", calibration);
    Execute(tx,
            "DELETE FROM rig_calibration WHERE rig = :rig AND run NOT IN (SELECT run FROM "
            "rig_calibration WHERE rig = :rig ORDER BY at_ms DESC, run LIMIT :kept)",
            {{"rig", calibration.rig}, {"kept", kKept}});
  });
}

core::Result<std::vector<RigCalibration>> RigCalibrations::List(const std::string& rig,
                                                                const std::string& bench,
                                                                int limit) {
  return database_.Read([&](Transaction& tx) {
    auto found = SelectRows<RigCalibration>(tx,
                                            "rig_calibration WHERE rig = :rig AND bench = :bench "
                                            "ORDER BY at_ms DESC, run LIMIT :limit",
                                            {{"rig", rig}, {"bench", bench}, {"limit", limit}});
    for (RigCalibration& each : found) {
      each.owner = SelectValue<std::string>(
                       tx, "SELECT owner FROM recording WHERE id = :run", {{"run", each.run}})
                       .value_or("");
    }
    return found;
  });
}

}  // namespace faultlab::server
