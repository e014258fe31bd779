#include "server/experiment/benches.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/types/check.h"
#include "hardware/bench/benches.h"

namespace faultlab::server {

namespace {

/// Far shorter than a bench that nothing names is kept.
constexpr auto kRenewed = std::chrono::hours(24);

}  // namespace

Benches::Benches(Database& database, std::vector<const core::Bench*> own)
    : store_(database), own_(std::move(own)) {
  LAB_CHECK(!own_.empty());
}

core::Result<std::vector<const core::Bench*>> Benches::List() {
  TRY(const auto texts, store_.TextsOfRigs());
  std::vector<const core::Bench*> list = own_;
  for (const std::string& text : texts) {
    const auto bench = hardware::KeepBench(text, "the bench of a rig");
    // What only a newer member can read is not this member's to show.
    if (!bench || std::ranges::find(list, bench.value()) != list.end()) continue;
    list.push_back(bench.value());
  }
  return list;
}

core::Result<const core::Bench*> Benches::ById(const std::string& id) {
  if (const core::Bench* kept = hardware::FindKeptBench(id)) return kept;
  TRY(const auto text, store_.Text(id));
  if (text.empty()) return nullptr;
  return hardware::KeepBench(text, "the stored bench " + id);
}

core::Result<const core::Bench*> Benches::Find(const std::string& id_or_name) {
  if (id_or_name.size() > kBenchNameBytesMax) {
    return core::Refuse("bench_name_long", "/bench");
  }
  TRY(const auto list, List());
  std::string known;
  for (const core::Bench* bench : list) {
    if (bench->id == id_or_name || bench->name == id_or_name) return bench;
    known += (known.empty() ? "" : ", ") + bench->name;
  }
  const auto stored = ById(id_or_name);
  if (!stored || stored.value() != nullptr) return stored;
  return core::Refuse("no_bench", "/bench", {{"benches", known}});
}

core::Result<const core::Bench*> Benches::OfRecording(const std::string& id) {
  if (id.empty()) return &hardware::PaperBench();
  const auto bench = ById(id);
  if (!bench || bench.value() != nullptr) return bench;
  return core::Refuse("bench_lost", "", {{"bench", id}});
}

core::Result<const core::Bench*> Benches::OfRig(const std::string& rig) {
  TRY(const auto text, store_.TextOfRig(rig));
  if (text.empty()) return &usual();
  return hardware::KeepBench(text, "the bench of " + rig);
}

core::Status Benches::NameOlderRecordings(WallTime now) {
  const core::Bench& paper = hardware::PaperBench();
  const core::Status kept = Keep(paper, now);
  return kept.ok() ? store_.NameOlderRecordings(paper.id) : kept;
}

core::Status Benches::Keep(const core::Bench& bench, WallTime now) {
  {
    const std::lock_guard lock(mutex_);
    const auto known = stored_.find(bench.id);
    if (known != stored_.end() && now - known->second < kRenewed && now >= known->second) {
      return core::Done{};
    }
  }
  TRY_DONE(store_.Add(bench.id, bench.text, now));
  const std::lock_guard lock(mutex_);
  stored_[bench.id] = now;
  return core::Done{};
}

core::Result<std::vector<std::string>> Benches::PutRigs(
    const std::map<std::string, const core::Bench*>& rigs, WallTime now) {
  std::map<std::string, std::string> ids;
  for (const auto& [rig, bench] : rigs) {
    TRY_DONE(Keep(*bench, now));
    ids[rig] = bench->id;
  }
  return store_.PutRigs(ids);
}

}  // namespace faultlab::server
