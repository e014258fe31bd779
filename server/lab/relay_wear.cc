#include "server/lab/relay_wear.h"

#include "server/storage/rows.h"

namespace faultlab::server::lab {

core::Status RelayWear::Add(const std::string& rig, const Closings& closings, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    for (const auto& [line, count] : closings) {
      InsertInto(
          tx,
          "relay_cycles",
          {{"rig", rig}, {"line", line}, {"cycles", count}, {"since_ms", now}},
          "ON CONFLICT (rig, line) DO UPDATE SET cycles = relay_cycles.cycles + excluded.cycles");
    }
  });
}

core::Result<std::map<int, RelayWear::Count>> RelayWear::Get(const std::string& rig) {
  using Counts = std::map<int, Count>;
  return database_.Read([&](Transaction& tx) {
    Counts counts;
    for (const auto& [line, cycles, since] : SelectTuples<int, std::int64_t, WallTime>(
             tx,
             "SELECT line, cycles, since_ms FROM relay_cycles WHERE rig = :rig",
             {{"rig", rig}})) {
      counts[line] = {cycles, since};
    }
    return counts;
  });
}

core::Status RelayWear::Replaced(const std::string& rig, int line, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    InsertInto(tx,
               "relay_cycles",
               {{"rig", rig}, {"line", line}, {"cycles", 0}, {"since_ms", now}},
               "ON CONFLICT (rig, line) DO UPDATE SET cycles = 0, since_ms = excluded.since_ms");
  });
}

}  // namespace faultlab::server::lab
