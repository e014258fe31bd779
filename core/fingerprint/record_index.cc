#include "core/fingerprint/record_index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

namespace faultlab::core {
namespace {

constexpr std::size_t kBlock = 32;
/// The shortest stretch that is compared, in blocks: 1.9 s at 100 Hz.
constexpr std::size_t kBlocksLeast = 5;
/// All channels together, and each alone.
constexpr double kChannelSets = 1.0 + static_cast<double>(kTracedChannels.size());
/// At most so many other records, and wrong places, say what is usual.
constexpr std::size_t kOthersMost = 64;
constexpr std::size_t kOthersLeast = 8;
constexpr double kNormalDecile = 1.64;  // of sizes
/// Of the records that one stretch may contain.
constexpr std::size_t kCopiesMost = 8;
/// Of a sample of a stretch and a record.
constexpr double kNsOfProducts = 4.0;
constexpr std::ptrdiff_t kWrongFrom = 5;
constexpr std::ptrdiff_t kWrongTo = 37;

/// Of the begin of a command.
std::uint64_t KeyOf(std::span<const float> uc_v) {
  std::uint64_t key = 14695981039346656037ULL;  // FNV-1a
  for (std::size_t k = 0; k < Command::kAnchor; ++k) {
    key = (key ^ std::bit_cast<std::uint32_t>(uc_v[k])) * 1099511628211ULL;
  }
  return key;
}

bool IsSameAsFarAsItGoes(std::span<const float> one, std::span<const float> other) {
  const std::size_t size = std::min(one.size(), other.size());
  return std::ranges::equal(one.first(size), other.first(size));
}

/// The noise of the brought record on the samples of a stretch.
struct Probe {
  std::size_t begin = 0;
  NoiseTraces traces;
  /// Sums of squares of all blocks before each, by channel.
  std::array<std::vector<double>, kTracedChannels.size()> squares;
};

/// Of a record with fewer samples than the known one, each stands at the nearest place alone.
NoiseTrace Resampled(const NoiseTrace& trace, std::span<const float> at) {
  if (trace.empty()) return {};
  const float rate = (at.back() - at.front()) / static_cast<float>(at.size() - 1);
  const bool fewer = static_cast<double>(rate) < kRateOfFewer;
  NoiseTrace out(at.size());
  for (std::size_t k = 0; k < at.size(); ++k) {
    const float nearest = std::round(at[k]);
    if (fewer) {
      const auto there = std::min(static_cast<std::size_t>(nearest), trace.size() - 1);
      if (2.0F * std::abs(at[k] - nearest) <= rate) out[k] = trace[there];
      continue;
    }
    const auto left = static_cast<std::size_t>(at[k]);
    const float share = at[k] - static_cast<float>(left);
    const std::size_t right = std::min(left + 1, trace.size() - 1);
    out[k] = static_cast<std::int8_t>(std::lround((1.0F - share) * static_cast<float>(trace[left]) +
                                                  share * static_cast<float>(trace[right])));
  }
  return out;
}

int Dot(const std::int8_t* one, const std::int8_t* other, std::size_t size) {
  int sum = 0;
  for (std::size_t k = 0; k < size; ++k) sum += one[k] * other[k];
  return sum;
}

Probe ProbeOf(const CommonStretch& stretch, const NoiseTraces& traces) {
  Probe probe;
  probe.begin = stretch.begin;
  for (std::size_t c = 0; c < traces.size(); ++c) {
    probe.traces[c] = Resampled(traces[c], stretch.at);
    const NoiseTrace& trace = probe.traces[c];
    double sum = 0.0;
    probe.squares[c].push_back(sum);
    for (std::size_t k = 0; k + kBlock <= trace.size(); k += kBlock) {
      sum += Dot(&trace[k], &trace[k], kBlock);
      probe.squares[c].push_back(sum);
    }
  }
  return probe;
}

/// Where a record stands out of noise: blocks [from, to) of a probe, in one channel or in all. A
/// copy may have the other sign.
struct Window {
  std::size_t from = 0;
  std::size_t to = 0;
  int channel = -1;  ///< -1: all
  double deviations = 0.0;
};

/// Sums of products of all blocks before each, by channel, as far as both go.
class Products {
 public:
  /// @param shift  samples by which the record is moved against its place
  void Make(const Probe& probe, const NoiseTraces& traces, std::ptrdiff_t shift) {
    blocks_ = 0;
    for (std::size_t c = 0; c < traces.size(); ++c) {
      sums_[c].clear();
      if (probe.traces[c].empty() || traces[c].empty()) continue;
      const std::ptrdiff_t begin = static_cast<std::ptrdiff_t>(probe.begin) + shift;
      double sum = 0.0;
      sums_[c].push_back(sum);
      for (std::size_t k = 0; k + kBlock <= probe.traces[c].size(); k += kBlock) {
        const std::ptrdiff_t at = begin + static_cast<std::ptrdiff_t>(k);
        if (at + static_cast<std::ptrdiff_t>(kBlock) >
            static_cast<std::ptrdiff_t>(traces[c].size())) {
          break;
        }
        if (at >= 0)
          sum += Dot(&probe.traces[c][k], &traces[c][static_cast<std::size_t>(at)], kBlock);
        sums_[c].push_back(sum);
      }
      blocks_ = std::max(blocks_, sums_[c].size() - 1);
    }
  }

  std::size_t blocks() const { return blocks_; }

  double Deviations(const Probe& probe, const Window& window) const {
    double product = 0.0;
    for (std::size_t c = 0; c < sums_.size(); ++c) {
      if (IsIn(window, c)) product += sums_[c][window.to] - sums_[c][window.from];
    }
    const double samples = Samples(probe, window);
    return samples <= 0.0 ? 0.0 : product / (kTraceUnit * kTraceUnit * std::sqrt(samples));
  }

  /// Known ones of the probe.
  double Samples(const Probe& probe, const Window& window) const {
    double squares = 0.0;
    for (std::size_t c = 0; c < sums_.size(); ++c) {
      if (IsIn(window, c)) squares += probe.squares[c][window.to] - probe.squares[c][window.from];
    }
    return squares / (kTraceUnit * kTraceUnit);
  }

 private:
  bool IsIn(const Window& window, std::size_t channel) const {
    const bool asked = window.channel < 0 || static_cast<std::size_t>(window.channel) == channel;
    return asked && sums_[channel].size() > window.to;
  }

  std::size_t blocks_ = 0;
  std::array<std::vector<double>, kTracedChannels.size()> sums_;
};

/// Lengths double from the shortest up to all there is; neighbours overlap.
template <typename Visit>
void VisitWindows(std::size_t blocks, Visit visit) {
  for (std::size_t length = kBlocksLeast; length <= blocks; length *= 2) {
    const std::size_t step = std::max<std::size_t>(1, length / 3);
    for (std::size_t from = 0; from + length <= blocks; from += step) visit(from, from + length);
  }
  if (blocks >= kBlocksLeast) visit(std::size_t{0}, blocks);
}

Window BestOf(const Products& products, const Probe& probe) {
  Window best;
  VisitWindows(products.blocks(), [&](std::size_t from, std::size_t to) {
    for (int channel = -1; channel < static_cast<int>(kTracedChannels.size()); ++channel) {
      Window window{from, to, channel, 0.0};
      window.deviations = std::abs(products.Deviations(probe, window));
      const bool strong = window.deviations >= RecordIndex::kCorrelationLeast *
                                                   std::sqrt(products.Samples(probe, window));
      if (strong && window.deviations > best.deviations) best = window;
    }
  });
  return best;
}

/// What one in ten exceeds.
double Decile(std::vector<double> values) {
  const auto at = values.end() - 1 - static_cast<std::ptrdiff_t>(values.size() / 10);
  std::ranges::nth_element(values, at);
  return *at;
}

/// A normal deviate that is exceeded by chance once in `tests` / `most` trials.
double Threshold(double tests, double most) {
  return std::sqrt(2.0 * std::log(0.5 * tests / most));
}

/// Hum and cogging agree at other places too, what a command leaves in every record agrees with the
/// other records too.
std::vector<RecordIndex::Copy> CopiesAt(const Probe& probe,
                                        std::span<const RecordIndex::Record> records,
                                        std::size_t all) {
  double windows = 0.0;
  const std::size_t blocks = std::ranges::max(probe.traces, {}, &NoiseTrace::size).size() / kBlock;
  VisitWindows(blocks, [&](std::size_t, std::size_t) { windows += 1.0; });
  const double least =
      Threshold(2.0 * static_cast<double>(all) * std::max(1.0, windows) * kChannelSets,
                RecordIndex::kFalseMost);
  std::vector<RecordIndex::Copy> copies;
  Products products;
  for (const RecordIndex::Record& record : records) {
    products.Make(probe, record.traces, 0);
    const Window most = BestOf(products, probe);
    if (most.deviations < least || copies.size() >= kCopiesMost) continue;
    double squares = 0.0;
    for (std::ptrdiff_t shift = kWrongFrom; shift < kWrongTo; ++shift) {
      products.Make(probe, record.traces, shift);
      const double deviations = products.Deviations(probe, most);
      squares += deviations * deviations;
    }
    const double wrong = std::sqrt(squares / static_cast<double>(kWrongTo - kWrongFrom));
    std::vector<double> others;
    for (const RecordIndex::Record& other : records) {
      if (&other == &record || others.size() == kOthersMost) continue;
      products.Make(probe, other.traces, 0);
      others.push_back(std::abs(products.Deviations(probe, most)));
    }
    const double usual = others.size() < kOthersLeast
                             ? 0.0
                             : std::max(0.0, Decile(std::move(others)) - kNormalDecile);
    const double deviations = (most.deviations - usual) / std::max(1.0, wrong);
    if (deviations >= least) copies.push_back({record.id, deviations});
  }
  return copies;
}

}  // namespace

RecordIndex::Entry RecordIndex::Prepare(std::span<const Sample> samples) {
  const DenseRecord record = Dense(samples);
  return {Command(record.uc), TracesOf(record, Surprises::kLeftOut)};
}

void RecordIndex::Put(std::int64_t id, Entry entry) {
  Remove(id);
  Command& command = entry.command;
  if (command.uc_v().size() < Command::kAnchor) return;
  const std::uint64_t key = KeyOf(command.uc_v());
  where_[id] = key;
  Record record{id, std::move(entry.traces)};
  const auto [first, last] = groups_.equal_range(key);
  for (auto at = first; at != last; ++at) {
    Group& group = at->second;
    if (!IsSameAsFarAsItGoes(group.command.uc_v(), command.uc_v())) continue;
    if (command.uc_v().size() > group.command.uc_v().size()) group.command = std::move(command);
    group.records.push_back(std::move(record));
    return;
  }
  Group group{std::move(command), {}};
  group.records.push_back(std::move(record));
  groups_.emplace(key, std::move(group));
}

void RecordIndex::Remove(std::int64_t id) {
  const auto known = where_.find(id);
  if (known == where_.end()) return;
  const auto [first, last] = groups_.equal_range(known->second);
  for (auto at = first; at != last; ++at) {
    std::vector<Record>& records = at->second.records;
    if (std::erase_if(records, [id](const Record& record) { return record.id == id; }) == 0)
      continue;
    if (records.empty()) groups_.erase(at);
    break;
  }
  where_.erase(known);
}

double RecordIndex::CostOf(std::size_t samples) const {
  double cost = 0.0;
  for (const auto& [key, group] : groups_) {
    cost += CostOfFindCommon(group.command.uc_v().size(), samples);
  }
  return cost;
}

RecordIndex::Found RecordIndex::Find(std::span<const Sample> brought, double ns_most) const {
  Found found;
  if (groups_.empty() || brought.size() < Command::kAnchor / 2) return found;
  const auto share_of_it = [&](double share) {
    return static_cast<std::size_t>(share * static_cast<double>(brought.size()));
  };
  const double cost = CostOf(brought.size());
  if (cost > ns_most) {
    found.samples_most = share_of_it(ns_most / cost);
    return found;
  }
  const DenseRecord record = Dense(brought);
  const Command command(record.uc);
  std::optional<NoiseTraces> traces;
  std::map<std::int64_t, double> copies;
  double ns_left = ns_most;
  std::size_t searched = 0;
  for (const auto& each : groups_) {
    const Group& group = each.second;
    FindCommon(group.command, command, ns_left, [&](const CommonStretch& stretch) {
      if (!traces) traces = TracesOf(record, Surprises::kKept);
      ns_left -= kNsOfProducts * static_cast<double>(stretch.at.size() * group.records.size());
      const Probe probe = ProbeOf(stretch, *traces);
      for (const Copy& copy : CopiesAt(probe, group.records, where_.size())) {
        double& most = copies[copy.id];
        most = std::max(most, copy.deviations);
      }
    });
    if (ns_left <= 0.0) {
      found.samples_most =
          share_of_it(static_cast<double>(searched + 1) / static_cast<double>(groups_.size() + 1));
      return found;
    }
    ++searched;
  }
  for (const auto& [id, deviations] : copies) found.copies.push_back({id, deviations});
  std::ranges::sort(found.copies, std::greater{}, &Copy::deviations);
  return found;
}

}  // namespace faultlab::core
