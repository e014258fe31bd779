#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/fingerprint/command_match.h"
#include "core/fingerprint/noise_trace.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// Records that are found again in what somebody brings, however it was cut, scaled, shifted,
/// rounded, resampled or covered with noise. A record is known by its noise, which no other run
/// has, at the place that its command tells:
///
///   command of the brought one --FindCommon--> stretches that both have
///   noise of the brought one, resampled to the stretch --correlation--> each record of this
///   command
///
/// A correlation over n samples is in noise that has nothing in common normal with variance 1 / n.
/// With added noise of g times its own it is 1 / sqrt(1 + g^2): 200 samples of one channel stand
/// out by 14 standard deviations, with noise of twice its own by 6.3, which is the least that may
/// be taken for a match among few records, and too little among very many. Not thread-safe.
class RecordIndex {
 public:
  /// Of how many brought records that have nothing to do with any of them one may be taken for a
  /// copy, as a share.
  static constexpr double kFalseMost = 1e-7;
  /// What a command leaves in every record of it gives weak correlations over long stretches: a
  /// copy has a strong one somewhere.
  static constexpr double kCorrelationLeast = 0.15;
  /// Of a search, in ns of a core.
  static constexpr double kCostMost = 1e10;

  /// A record as it is searched: 4 bytes for each sample, and 16 where no other has its command.
  struct Entry {
    Command command;
    NoiseTraces traces;
  };
  static Entry Prepare(std::span<const Sample> samples);

  /// A record as it is so far, in place of what was known of it. Nothing shorter than
  /// Command::kAnchor can be found.
  void Put(std::int64_t id, Entry entry);
  void Put(std::int64_t id, std::span<const Sample> samples) { Put(id, Prepare(samples)); }
  void Remove(std::int64_t id);
  std::size_t size() const { return where_.size(); }

  struct Copy {
    std::int64_t id = 0;
    double deviations = 0.0;  ///< by which the correlation stands out
  };
  struct Found {
    std::vector<Copy> copies;  ///< of different records, the clearest first
    /// More than so many samples would take too long to compare: then nothing is known.
    std::optional<std::size_t> samples_most{};
  };
  /// What Find spends at least on so many samples, in ns.
  double CostOf(std::size_t samples) const;
  Found Find(std::span<const Sample> brought, double ns_most = kCostMost) const;

  struct Record {
    std::int64_t id = 0;
    NoiseTraces traces;
  };

 private:
  /// Records whose commands are the same as far as they go.
  struct Group {
    Command command;
    std::vector<Record> records;
  };

  std::unordered_multimap<std::uint64_t, Group> groups_;  ///< by the begin of the command
  std::map<std::int64_t, std::uint64_t> where_;
};

}  // namespace faultlab::core
