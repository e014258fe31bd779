#include "core/fingerprint/command_match.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace faultlab::core {
namespace {

constexpr std::size_t kBits = 64;
/// Anchors of the other command are so far apart that each 2 s at 100 Hz contain one.
constexpr std::size_t kAnchorsApart = 64;
constexpr double kRateMost = 0.05;
constexpr double kRateStep = 0.005;
/// Other rates, near which a record is looked for too: rows left out, or each twice.
constexpr std::array<double, 5> kOtherRates = {1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0, 2.0};
constexpr int kRates = 21 + 3 * static_cast<int>(kOtherRates.size());
/// Of 64 bits that differ: unrelated ones differ in 32, 14 or fewer once in 300 000.
constexpr std::uint64_t kDifferMost = 14;
constexpr std::size_t kHitsMost = 4096;
/// Few bits of one kind say little.
constexpr int kBitsLeast = 4;
constexpr std::size_t kPlacesMost = 64;
/// Of the voltages. A command that was resampled twice has 0.8 where it changes at each sample.
constexpr double kCorrelationLeast = 0.75;
/// Of a place that is worth refining: words that agree by chance have 0.5.
constexpr double kPromising = 0.6;
constexpr std::ptrdiff_t kHalf = 32;
constexpr float kStill = 0.01F;

/// at = offset + rate * index of the known one.
struct Line {
  double offset = 0.0;
  double rate = 1.0;

  double At(double index) const { return offset + rate * index; }
};

std::optional<double> Interpolated(std::span<const float> values, double at) {
  if (at < 0.0 || at > static_cast<double>(values.size() - 1)) return std::nullopt;
  const auto left = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(left);
  if (share == 0.0) return values[left];
  return (1.0 - share) * static_cast<double>(values[left]) +
         share * static_cast<double>(values[left + 1]);
}

/// Correlation of the voltages over the places of `known` around `middle`, whatever its sign: 1
/// where both stand still, 0 where one of them does, or ends.
double Correlation(const Command& known_command,
                   const Command& other_command,
                   std::ptrdiff_t middle,
                   std::ptrdiff_t half,
                   const Line& line) {
  const std::span<const float> known = known_command.uc_v();
  const std::span<const float> other = other_command.uc_v();
  const std::ptrdiff_t from = middle - half;
  const std::ptrdiff_t to = middle + half;
  if (from < 0 || to > static_cast<std::ptrdiff_t>(known.size())) return 0.0;
  double x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0, n = 0.0;
  // Where the other one has fewer samples, each of them is compared, and nothing between them.
  const double first =
      line.rate < kRateOfFewer ? std::ceil(line.At(static_cast<double>(from))) : 0.0;
  for (std::ptrdiff_t step = 0;; ++step) {
    const double at = line.rate < kRateOfFewer
                          ? (first + static_cast<double>(step) - line.offset) / line.rate
                          : static_cast<double>(from + step);
    if (at >= static_cast<double>(to)) break;
    const auto here = Interpolated(known, at);
    const auto there = Interpolated(other, line.At(at));
    if (!here || !there) return 0.0;
    x += *here;
    y += *there;
    xx += *here * *here;
    yy += *there * *there;
    xy += *here * *there;
    n += 1.0;
  }
  const double spread = xx - x * x / n;
  const double other_spread = yy - y * y / n;
  const auto stands = [n](const Command& command, double sum) {
    const double still = command.still();
    return sum <= n * still * still;
  };
  const bool known_stands = stands(known_command, spread);
  const bool other_stands = stands(other_command, other_spread);
  if (known_stands || other_stands) return known_stands && other_stands ? 1.0 : 0.0;
  return std::abs(xy - x * y / n) / std::sqrt(spread * other_spread);
}

constexpr double kNsOfCorrelation = 16.0;  // for each sample
constexpr double kNsOfWord = 1.3;

/// What is tried around a line: steps of offset, at the middle, and of rate.
struct Steps {
  double offset = 0.0;
  int offsets = 0;  ///< on each side
  double rate = 0.0;
  int rates = 0;

  int tries() const { return 1 + (2 * rates + 1) * (2 * offsets + 1); }
};

/// Of a command with fewer samples a word has one bit for each.
std::size_t StrideAt(double rate) {
  return rate < kRateOfFewer ? static_cast<std::size_t>(std::lround(1.0 / rate)) : Command::kStride;
}

/// Bits of the other command from `from` on, as they would stand in the known one.
std::uint64_t WordAt(const Command& command, double from, double rate) {
  const double step = rate * static_cast<double>(StrideAt(rate));
  std::uint64_t word = 0;
  const double still = command.still();
  for (std::size_t bit = 0; bit < kBits; ++bit) {
    const auto value = Interpolated(command.wave(), from + step * static_cast<double>(bit));
    if (value && *value > still) word |= std::uint64_t{1} << bit;
  }
  return word;
}

/// Nearest to 1 first.
const std::vector<double>& Rates() {
  static const std::vector<double> kAll = [] {
    std::vector<double> rates;
    const int steps = static_cast<int>(std::lround(kRateMost / kRateStep));
    for (int step = 0; step <= 2 * steps; ++step) {
      rates.push_back(1.0 + kRateStep * (step % 2 == 0 ? step / 2 : -(step + 1) / 2));
    }
    for (const double other : kOtherRates) {
      for (const double off : {0.0, kRateStep, -kRateStep}) rates.push_back(other * (1.0 + off));
    }
    return rates;
  }();
  return kAll;
}

/// Bits of `word` that differ from those of each of `words`. Without branches, so that compilers
/// take several at once.
void CountDiffering(std::uint64_t word,
                    std::span<const std::uint64_t> words,
                    std::vector<std::uint64_t>* counts) {
  counts->resize(words.size());
  std::uint64_t* const out = counts->data();
  for (std::size_t k = 0; k < words.size(); ++k) {
    std::uint64_t x = word ^ words[k];
    x -= (x >> 1U) & 0x5555555555555555U;
    x = (x & 0x3333333333333333U) + ((x >> 2U) & 0x3333333333333333U);
    x = (x + (x >> 4U)) & 0x0f0f0f0f0f0f0f0fU;
    x += x >> 8U;
    x += x >> 16U;
    x += x >> 32U;
    out[k] = x & 0x7fU;
  }
}

class Finder {
 public:
  Finder(const Command& known, const Command& other, double& ns_left)
      : known_(known), other_(other), ns_left_(ns_left) {}

  void Find(const std::function<void(const CommonStretch&)>& visit) {
    const std::size_t size = other_.wave().size();
    for (std::size_t anchor = 0; anchor < size && ns_left_ > 0.0; anchor += kAnchorsApart) {
      Look(static_cast<double>(anchor), visit);
    }
  }

 private:
  struct Place {
    std::size_t at = 0;  ///< in the known command
    double rate = 1.0;
    int differ = 0;
  };

  /// The best line around `around`, with its correlation.
  std::pair<Line, double> Refined(std::ptrdiff_t middle,
                                  std::ptrdiff_t half,
                                  const Line& around,
                                  const Steps& steps) const {
    ns_left_ -= kNsOfCorrelation * 2.0 * static_cast<double>(half) * steps.tries();
    std::pair<Line, double> best{around, Correlation(known_, other_, middle, half, around)};
    const auto index = static_cast<double>(middle);
    for (int r = -steps.rates; r <= steps.rates; ++r) {
      for (int o = -steps.offsets; o <= steps.offsets; ++o) {
        Line line;
        line.rate = around.rate + steps.rate * r;
        line.offset = around.At(index) + steps.offset * o - line.rate * index;
        const double correlation = Correlation(known_, other_, middle, half, line);
        if (correlation > best.second + 1e-9) best = {line, correlation};
      }
    }
    return best;
  }

  /// A stretch that was told, by some of its places.
  struct Found {
    std::ptrdiff_t begin = 0;
    std::vector<float> at;
  };
  static constexpr std::ptrdiff_t kFoundEvery = 16;

  void Look(double anchor, const std::function<void(const CommonStretch&)>& visit) {
    for (const Place& place : PlacesOf(anchor)) {
      if (ns_left_ <= 0.0) return;
      Line line;
      line.rate = place.rate;
      line.offset = anchor - place.rate * static_cast<double>(place.at);
      const auto middle = static_cast<std::ptrdiff_t>(place.at) + 2 * kHalf;
      if (IsFound(middle, line.At(static_cast<double>(middle)))) continue;
      if (Refined(middle, 2 * kHalf, line, {0.5, 2}).second < kPromising) continue;
      auto refined = Refined(middle, 2 * kHalf, line, {0.25, 8, 0.001, 4});
      refined = Refined(middle, 2 * kHalf, refined.first, {0.05, 5, 0.0002, 5});
      if (refined.second < kCorrelationLeast) continue;
      const CommonStretch stretch = Grown(middle, refined.first);
      Found found{static_cast<std::ptrdiff_t>(stretch.begin), {}};
      for (std::size_t k = 0; k < stretch.at.size(); k += kFoundEvery) {
        found.at.push_back(stretch.at[k]);
      }
      found_.push_back(std::move(found));
      visit(stretch);
    }
  }

  bool IsFound(std::ptrdiff_t middle, double at) const {
    return std::ranges::any_of(found_, [&](const Found& found) {
      const std::ptrdiff_t k = middle - found.begin;
      const std::ptrdiff_t left = k / kFoundEvery;
      if (k < 0 || left + 1 >= static_cast<std::ptrdiff_t>(found.at.size())) return false;
      const auto here = static_cast<double>(found.at[static_cast<std::size_t>(left)]);
      const auto next = static_cast<double>(found.at[static_cast<std::size_t>(left + 1)]);
      const double share = static_cast<double>(k % kFoundEvery) / kFoundEvery;
      return std::abs(here + share * (next - here) - at) < 2.0;
    });
  }

  std::span<const std::uint64_t> KnownWords(std::size_t stride) {
    if (stride == Command::kStride) return known_.words();
    const auto [words, is_new] = words_.try_emplace(stride);
    if (is_new) words->second = known_.WordsOf(stride);
    return words->second;
  }

  std::vector<Place> PlacesOf(double anchor) {
    std::vector<Place> places;
    const auto size = static_cast<double>(other_.wave().size());
    for (const double rate : Rates()) {
      const std::size_t stride = StrideAt(rate);
      if (anchor + rate * static_cast<double>(stride * (kBits - 1)) > size - 1.0) continue;
      const std::span<const std::uint64_t> words = KnownWords(stride);
      const std::uint64_t word = WordAt(other_, anchor, rate);
      const int ones = std::popcount(word);
      if (std::min(ones, static_cast<int>(kBits) - ones) < kBitsLeast) continue;
      CountDiffering(word, words, &differing_);
      ns_left_ -= kNsOfWord * static_cast<double>(words.size());
      for (std::size_t at = 0; at < words.size(); ++at) {
        // A command with the other sign differs in all bits.
        const std::uint64_t differ = std::min(differing_[at], kBits - differing_[at]);
        if (differ > kDifferMost || places.size() >= kHitsMost) continue;
        places.push_back({at, rate, static_cast<int>(differ)});
      }
    }
    std::ranges::stable_sort(places, {}, &Place::differ);
    std::vector<Place> apart;
    for (const Place& place : places) {
      const bool near = std::ranges::any_of(apart, [&place](const Place& other) {
        return place.at + 3 > other.at && other.at + 3 > place.at;
      });
      if (!near) apart.push_back(place);
      if (apart.size() == kPlacesMost) break;
    }
    return apart;
  }

  /// From the place of an anchor to both sides, as long as the voltages agree.
  CommonStretch Grown(std::ptrdiff_t middle, const Line& line) const {
    std::vector<std::pair<std::ptrdiff_t, double>> after;
    std::vector<std::pair<std::ptrdiff_t, double>> before;
    Follow(middle, kHalf, line, &after);
    Follow(middle, -kHalf, line, &before);
    std::vector<std::pair<std::ptrdiff_t, double>> knots(before.rbegin(), before.rend());
    knots.emplace_back(middle, line.At(static_cast<double>(middle)));
    knots.insert(knots.end(), after.begin(), after.end());
    // The first and the last knot stand for the samples beyond them, too.
    CommonStretch stretch;
    std::ptrdiff_t begin = knots.front().first - kHalf;
    std::ptrdiff_t end = knots.back().first + kHalf;
    if (before.empty()) begin -= kHalf;
    if (after.empty()) end += kHalf;
    stretch.begin = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, begin));
    const auto known = static_cast<std::ptrdiff_t>(known_.uc_v().size());
    std::size_t next = 0;
    for (auto k = static_cast<std::ptrdiff_t>(stretch.begin); k < std::min(end, known); ++k) {
      while (next + 2 < knots.size() && knots[next + 1].first < k) ++next;
      double at = knots[0].second + line.rate * static_cast<double>(k - knots[0].first);
      if (knots.size() > 1) {
        const auto& [left, left_at] = knots[next];
        const auto& [right, right_at] = knots[next + 1];
        at = left_at + (right_at - left_at) * static_cast<double>(k - left) /
                           static_cast<double>(right - left);
      }
      const auto last = static_cast<double>(other_.uc_v().size() - 1);
      stretch.at.push_back(static_cast<float>(std::clamp(at, 0.0, last)));
    }
    return stretch;
  }

  void Follow(std::ptrdiff_t middle,
              std::ptrdiff_t step,
              Line line,
              std::vector<std::pair<std::ptrdiff_t, double>>* knots) const {
    const auto size = static_cast<double>(other_.uc_v().size());
    for (std::ptrdiff_t at = middle + step;; at += step) {
      const double there = line.At(static_cast<double>(at));
      if (at < kHalf || at + kHalf > static_cast<std::ptrdiff_t>(known_.uc_v().size()) ||
          there < 0.0 || there > size - 1.0) {
        return;
      }
      const auto [refined, correlation] = Refined(at, kHalf, line, {0.1, 5});
      if (correlation < kCorrelationLeast) return;
      const double off = refined.At(static_cast<double>(at)) - there;
      // A command that stands still says nothing of the rate.
      line.rate += 0.2 * off / static_cast<double>(step);
      line.offset = there + off - line.rate * static_cast<double>(at);
      knots->emplace_back(at, there + off);
    }
  }

  const Command& known_;
  const Command& other_;
  double& ns_left_;
  std::vector<Found> found_;
  std::vector<std::uint64_t> differing_;
  std::map<std::size_t, std::vector<std::uint64_t>> words_;  ///< of the known one, by stride
};

}  // namespace

Command::Command(const DenseChannel& uc) : uc_v_(uc.values), wave_(uc.values.size()) {
  float newest = uc.middle;
  for (float& value : uc_v_) newest = value = std::isnan(value) ? newest : value;
  still_ = kStill * uc.span;
  const std::size_t size = uc_v_.size();
  std::vector<double> sum(size + 1);
  for (std::size_t k = 0; k < size; ++k) sum[k + 1] = sum[k] + static_cast<double>(uc_v_[k]);
  for (std::size_t k = 0; k < size; ++k) {
    const std::size_t from = k < kAnchor / 2 ? 0 : k - kAnchor / 2;
    const std::size_t to = std::min(size, k + kAnchor / 2);
    const double mean = (sum[to] - sum[from]) / static_cast<double>(to - from);
    wave_[k] = static_cast<float>(static_cast<double>(uc_v_[k]) - mean);
  }
  if (size < kAnchor) return;
  words_ = WordsOf(kStride);
}

std::vector<std::uint64_t> Command::WordsOf(std::size_t stride) const {
  const std::size_t last = stride * (kBits - 1);
  std::vector<std::uint64_t> words(wave_.size() > last ? wave_.size() - last : 0);
  for (std::size_t at = 0; at < words.size(); ++at) {
    for (std::size_t bit = 0; bit < kBits; ++bit) {
      if (wave_[at + stride * bit] > still_) words[at] |= std::uint64_t{1} << bit;
    }
  }
  return words;
}

double CostOfFindCommon(std::size_t known, std::size_t other) {
  return kNsOfWord * kRates * static_cast<double>(known) * static_cast<double>(other) /
         static_cast<double>(kAnchorsApart);
}

void FindCommon(const Command& known,
                const Command& other,
                double& ns_left,
                const std::function<void(const CommonStretch&)>& visit) {
  if (known.uc_v().size() >= Command::kAnchor) Finder(known, other, ns_left).Find(visit);
}

}  // namespace faultlab::core
