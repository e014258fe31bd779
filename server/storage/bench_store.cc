#include "server/storage/bench_store.h"

#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using soci::into;
using soci::use;

core::Result<std::string> TextBy(Database& database, const char* query, const std::string& key) {
  return database.Read([&](Transaction& tx) {
    std::string text;
    tx.sql() << query, into(text), use(key, "key");
    return text;
  });
}

}  // namespace

core::Status BenchStore::Add(const std::string& id, const std::string& text, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "INSERT INTO bench (id, text, since_ms) VALUES (:id, :text, :since) "
                "ON CONFLICT (id) DO UPDATE SET since_ms = excluded.since_ms",
        use(id, "id"), use(text, "text"), use(now_ms, "since");
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
      std::string before;
      tx.sql() << "SELECT bench FROM rig_bench WHERE rig = :rig", into(before), use(rig, "rig");
      if (before == bench) continue;
      if (!before.empty()) others.push_back(rig);
      tx.sql() << "INSERT INTO rig_bench (rig, bench) VALUES (:rig, :bench) "
                  "ON CONFLICT (rig) DO UPDATE SET bench = excluded.bench",
          use(rig, "rig"), use(bench, "bench");
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
    tx.sql() << "UPDATE recording SET bench = :id WHERE bench = ''", use(id, "id");
    tx.sql() << "UPDATE rig_calibration SET bench = :id WHERE bench = ''", use(id, "id");
  });
}

}  // namespace faultlab::server
