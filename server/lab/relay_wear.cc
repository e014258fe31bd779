#include "server/lab/relay_wear.h"

#include <soci/soci.h>

namespace faultlab::server::lab {

using soci::into;
using soci::use;

core::Status RelayWear::Add(const std::string& rig, const Closings& closings, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::int64_t now_ms = ToMilliseconds(now);
    for (const auto& [line, count] : closings) {
      tx.sql() << "INSERT INTO relay_cycles (rig, line, cycles, since_ms) "
                  "VALUES (:rig, :line, :count, :now) ON CONFLICT (rig, line) DO UPDATE SET "
                  "cycles = relay_cycles.cycles + excluded.cycles",
          use(rig, "rig"), use(line, "line"), use(count, "count"), use(now_ms, "now");
    }
  });
}

core::Result<std::map<int, RelayWear::Count>> RelayWear::Get(const std::string& rig) {
  using Counts = std::map<int, Count>;
  return database_.Read([&](Transaction& tx) {
    Counts counts;
    std::int64_t line = 0;
    std::int64_t cycles = 0;
    std::int64_t since_ms = 0;
    soci::statement query =
        (tx.sql().prepare << "SELECT line, cycles, since_ms FROM relay_cycles WHERE rig = :rig",
         into(line),
         into(cycles),
         into(since_ms),
         use(rig, "rig"));
    query.execute();
    while (query.fetch()) counts[static_cast<int>(line)] = {cycles, FromMilliseconds(since_ms)};
    return counts;
  });
}

core::Status RelayWear::Replaced(const std::string& rig, int line, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "INSERT INTO relay_cycles (rig, line, cycles, since_ms) "
                "VALUES (:rig, :line, 0, :now) ON CONFLICT (rig, line) DO UPDATE SET "
                "cycles = 0, since_ms = excluded.since_ms",
        use(rig, "rig"), use(line, "line"), use(now_ms, "now");
  });
}

}  // namespace faultlab::server::lab
