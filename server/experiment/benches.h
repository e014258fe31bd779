#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "server/storage/bench_store.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// No id or name of a bench is longer.
inline constexpr std::size_t kBenchNameBytesMax = 64;

/// The benches that the servers of one database know: this server's own, by its settings; those of
/// rigs on a bus; and every one that a recording was made with, so that it stays readable.
/// Thread-safe.
class Benches {
 public:
  /// @param own  not empty; the first is taken when a request names no bench
  Benches(Database& database, std::vector<const core::Bench*> own);

  const core::Bench& usual() const { return *own_.front(); }
  /// Own ones, then those of rigs, each once.
  core::Result<std::vector<const core::Bench*>> List();
  /// By Bench::id, or by the name of one in List(). kNotFound names what there is.
  core::Result<const core::Bench*> Find(const std::string& id_or_name);
  /// By the id in a recording; empty in those of programs that knew the paper's bench alone.
  core::Result<const core::Bench*> OfRecording(const std::string& id);
  /// Of a rig of any member; usual() when no member has told.
  core::Result<const core::Bench*> OfRig(const std::string& rig);

  /// Recordings and calibrations of programs that knew the paper's bench alone get its id. At the
  /// start of a server.
  core::Status NameOlderRecordings(WallTime now);

  /// Stores the description, again once a day; before a recording names it.
  core::Status Keep(const core::Bench& bench, WallTime now);
  /// Stores what rigs are built like.
  /// @returns those that were another bench before
  core::Result<std::vector<std::string>> PutRigs(
      const std::map<std::string, const core::Bench*>& rigs, WallTime now);

 private:
  core::Result<const core::Bench*> ById(const std::string& id);

  BenchStore store_;
  const std::vector<const core::Bench*> own_;
  std::mutex mutex_;
  std::map<std::string, WallTime> stored_;  ///< by id, when the database was last given it
};

}  // namespace faultlab::server
