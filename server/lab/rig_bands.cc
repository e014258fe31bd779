#include "server/lab/rig_bands.h"

#include "server/storage/rows.h"

namespace faultlab::server::lab {

template <typename Visit>
void Fields(RigBand& band, Visit&& visit) {
  visit("b0d", band.b0d);
  visit("gain", band.gain);
  visit("a1d", band.a1d);
}

namespace {

struct Row {
  std::string rig;
  RigBand band;
  std::string source;
  WallTime at;
};

template <typename Visit>
void Fields(Row& row, Visit&& visit) {
  visit("rig", row.rig);
  lab::Fields(row.band, visit);
  visit("source", row.source);
  visit("at_ms", row.at);
}

}  // namespace

core::Result<std::optional<RigBand>> RigBands::Get(const std::string& rig) {
  return database_.Read([&](Transaction& tx) {
    return SelectRow<RigBand>(tx, "rig_band WHERE rig = :rig", {{"rig", rig}});
  });
}

core::Status RigBands::Put(const std::string& rig,
                           const RigBand& band,
                           const std::string& source,
                           WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    PutRow(tx, "rig_band", Row{rig, band, source, now});
  });
}

core::Status RigBands::Forget(const std::string& rig) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    DeleteFrom(tx, "rig_band", {{"rig", rig}});
  });
}

}  // namespace faultlab::server::lab
