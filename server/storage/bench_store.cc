#include "server/storage/bench_store.h"

#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

core::Result<std::string> TextBy(Database& database, const char* query, const std::string& key) {
  return database.Read([&](Transaction& tx) {
    return SelectValue<std::string>(tx, query, {{"key", key}}).value_or("");
  });
}

}  // namespace

core::Status BenchStore::Add(const std::string& id, const std::string& text, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    InsertInto(tx,
               "bench",
               {{"id", id}, {"text", text}, {"since_ms", now}},
               "ON CONFLICT (id) DO UPDATE SET since_ms = excluded.since_ms");
  });
}

core::Result<std::string> BenchStore::Text(const std::string& id) {
  return TextBy(database_, "SELECT text FROM bench WHERE id = :key", id);
}

core::Result<std::vector<std::string>> BenchStore::PutRigs(
    const std::map<std::string, std::string>& rigs) {
  using Rigs = std::vector<std::string>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    Rigs others;
    for (const auto& [rig, bench] : rigs) {
      const auto before = SelectValue<std::string>(
                              tx, "SELECT bench FROM rig_bench WHERE rig = :rig", {{"rig", rig}})
                              .value_or("");
      if (before == bench) continue;
      if (!before.empty()) others.push_back(rig);
      InsertInto(tx,
                 "rig_bench",
                 {{"rig", rig}, {"bench", bench}},
                 "ON CONFLICT (rig) DO UPDATE SET bench = excluded.bench");
    }
    return others;
  });
}

core::Result<std::string> BenchStore::TextOfRig(const std::string& rig) {
  return TextBy(database_,
                "SELECT b.text FROM rig_bench r JOIN bench b ON b.id = r.bench WHERE r.rig = :key",
                rig);
}

core::Result<std::vector<std::string>> BenchStore::TextsOfRigs() {
  return database_.Read([&](Transaction& tx) {
    return SelectColumn<std::string>(
        tx,
        "SELECT b.text FROM rig_bench r JOIN bench b ON b.id = r.bench GROUP BY b.id, b.text "
        "ORDER BY MIN(r.rig)");
  });
}

core::Status BenchStore::NameOlderRecordings(const std::string& id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    UpdateWhere(tx, "recording", {{"bench", id}}, {{"bench", ""}});
    UpdateWhere(tx, "rig_calibration", {{"bench", id}}, {{"bench", ""}});
  });
}

}  // namespace faultlab::server
