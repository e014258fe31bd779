#include "hardware/bench/benches.h"

#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "core/types/check.h"
#include "hardware/bench/bench_reader.h"
#include "hardware/bench/shipped_benches.h"
#include "hardware/config/toml_table.h"

namespace faultlab::hardware {

namespace {

/// Every bench that this process has read.
class KeptBenches {
 public:
  core::Result<const core::Bench*> Keep(std::string_view text, std::string_view name) {
    const std::lock_guard lock(mutex_);
    const auto found = kept_.find(text);
    if (found != kept_.end()) return found->second;
    if (text.size() > kBenchTextBytesMax) {
      return core::Error{core::ErrorCode::kInvalid,
                         std::string(name) + ": longer than " +
                             std::to_string(kBenchTextBytesMax / 1024) +
                             " kB: this is no description of a bench",
                         "bench"};
    }
    if (kept_.size() >= kBenchesMax) {
      return core::Error{core::ErrorCode::kUnavailable,
                         "this process has read " + std::to_string(kBenchesMax) +
                             " descriptions of benches: start it anew",
                         "bench"};
    }
    TRY(auto bench, ReadBench(text, name));
    std::unique_ptr<const core::Bench>& owned = benches_[bench.id];
    if (owned == nullptr) owned = std::make_unique<const core::Bench>(std::move(bench));
    return kept_.emplace(std::string(text), owned.get()).first->second;
  }

  const core::Bench* Find(std::string_view id) {
    const std::lock_guard lock(mutex_);
    const auto found = benches_.find(id);
    return found != benches_.end() ? found->second.get() : nullptr;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::unique_ptr<const core::Bench>, std::less<>> benches_;  ///< by id
  std::map<std::string, const core::Bench*, std::less<>> kept_;                     ///< by text
};

KeptBenches& Kept() {
  static KeptBenches kept;
  return kept;
}

}  // namespace

core::Result<const core::Bench*> KeepBench(std::string_view text, std::string_view name) {
  return Kept().Keep(text, name);
}

const core::Bench* FindKeptBench(std::string_view id) {
  return Kept().Find(id);
}

core::Result<const core::Bench*> LoadBench(const std::string& path) {
  if (path.empty()) return &PaperBench();
  for (const ShippedBench& shipped : ShippedBenches()) {
    if (path == shipped.name) return KeepBench(shipped.text, path + ".toml");
  }
  TRY(const auto text, LoadText(path));
  return KeepBench(text, path);
}

std::vector<const core::Bench*> LoadShippedBenches() {
  std::vector<const core::Bench*> benches;
  for (const ShippedBench& shipped : ShippedBenches()) {
    const auto bench = LoadBench(std::string(shipped.name));
    LAB_CHECK(bench.ok(), bench.ok() ? "" : bench.error().message);
    benches.push_back(bench.value());
  }
  return benches;
}

core::Result<const core::BenchProfile*> FindProfile(const core::Bench& bench,
                                                    std::string_view name) {
  if (name.empty()) return &bench.profiles.front();
  if (const core::BenchProfile* found = bench.FindProfile(name)) return found;
  std::string known;
  for (const core::BenchProfile& each : bench.profiles) {
    known += (known.empty() ? "\"" : ", \"") + each.name + "\"";
  }
  return core::Refuse("no_profile", "profile", {{"profile", name}, {"known", known}});
}

const core::Bench& PaperBench() {
  static const core::Bench& bench = [&]() -> const core::Bench& {
    const auto kept = LoadBench(std::string(ShippedBenches().front().name));
    LAB_CHECK(kept.ok(), kept.ok() ? "" : kept.error().message);
    return *kept.value();
  }();
  return bench;
}

}  // namespace faultlab::hardware
