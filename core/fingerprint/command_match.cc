#include "core/fingerprint/command_match.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

namespace faultlab::core {
namespace {

constexpr std::size_t kBits = 64;
constexpr double kStride = 2.0;
/// Anchors of the other command are so far apart that each 2 s at 100 Hz contain one.
constexpr std::size_t kAnchorsApart = 64;
constexpr double kRateMost = 0.05;
constexpr double kRateStep = 0.005;
/// Of 64 bits that differ: unrelated ones differ in 32, 14 or fewer once in 300 000.
constexpr std::uint64_t kDifferMost = 14;
/// Few bits of one kind say little.
constexpr int kBitsLeast = 4;
constexpr std::size_t kPlacesMost = 64;
/// Of the voltages. A command that was resampled twice has 0.8 where it changes at each sample.
constexpr double kCorrelationLeast = 0.75;
constexpr std::ptrdiff_t kHalf = 32;
/// Below this share of its square a voltage stands still.
constexpr double kStill = 1e-9;

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

/// Correlation of the voltages over the samples of `known` around `middle`: 1 where both stand
/// still, 0 where one of them does, or ends.
double Correlation(std::span<const float> known,
                   std::span<const float> other,
                   std::ptrdiff_t middle,
                   std::ptrdiff_t half,
                   const Line& line) {
  const std::ptrdiff_t from = middle - half;
  const std::ptrdiff_t to = middle + half;
  if (from < 0 || to > static_cast<std::ptrdiff_t>(known.size())) return 0.0;
  double x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
  for (std::ptrdiff_t k = from; k < to; ++k) {
    const auto there = Interpolated(other, line.At(static_cast<double>(k)));
    if (!there) return 0.0;
    const double here = known[static_cast<std::size_t>(k)];
    x += here;
    y += *there;
    xx += here * here;
    yy += *there * *there;
    xy += here * *there;
  }
  const auto n = static_cast<double>(to - from);
  const double spread = xx - x * x / n;
  const double other_spread = yy - y * y / n;
  const bool stands = spread <= kStill * xx;
  const bool other_stands = other_spread <= kStill * yy;
  if (stands || other_stands) return stands && other_stands ? 1.0 : 0.0;
  return (xy - x * y / n) / std::sqrt(spread * other_spread);
}

/// The best line within so many steps of offset, at `middle`, and of rate.
std::pair<Line, double> Refined(std::span<const float> known,
                                std::span<const float> other,
                                std::ptrdiff_t middle,
                                std::ptrdiff_t half,
                                const Line& around,
                                double offset_step,
                                int offset_steps,
                                double rate_step,
                                int rate_steps) {
  std::pair<Line, double> best{around, Correlation(known, other, middle, half, around)};
  const auto index = static_cast<double>(middle);
  for (int r = -rate_steps; r <= rate_steps; ++r) {
    for (int o = -offset_steps; o <= offset_steps; ++o) {
      Line line;
      line.rate = around.rate + rate_step * r;
      line.offset = around.At(index) + offset_step * o - line.rate * index;
      const double correlation = Correlation(known, other, middle, half, line);
      if (correlation > best.second + 1e-9) best = {line, correlation};
    }
  }
  return best;
}

/// Bits of the other command from `from` on, as they would stand in the known one.
std::uint64_t WordAt(const Command& command, double from, double rate) {
  std::uint64_t word = 0;
  const double still = command.still();
  for (std::size_t bit = 0; bit < kBits; ++bit) {
    const auto value =
        Interpolated(command.wave(), from + kStride * rate * static_cast<double>(bit));
    if (value && *value > still) word |= std::uint64_t{1} << bit;
  }
  return word;
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
  Finder(const Command& known, const Command& other) : known_(known), other_(other) {}

  std::vector<CommonStretch> Find() {
    const double reach = kStride * (kBits - 1) * (1.0 + kRateMost);
    const auto size = static_cast<double>(other_.wave().size());
    for (std::size_t anchor = 0; static_cast<double>(anchor) + reach <= size - 1.0;
         anchor += kAnchorsApart) {
      Look(static_cast<double>(anchor));
    }
    return std::move(found_);
  }

 private:
  struct Place {
    std::size_t at = 0;  ///< in the known command
    double rate = 1.0;
    int differ = 0;
  };

  void Look(double anchor) {
    for (const Place& place : PlacesOf(anchor)) {
      Line line;
      line.rate = place.rate;
      line.offset = anchor - place.rate * static_cast<double>(place.at);
      const auto middle = static_cast<std::ptrdiff_t>(place.at) + 2 * kHalf;
      if (IsFound(middle, line.At(static_cast<double>(middle)))) continue;
      auto refined =
          Refined(known_.uc_v(), other_.uc_v(), middle, 2 * kHalf, line, 0.25, 8, 0.001, 4);
      refined = Refined(
          known_.uc_v(), other_.uc_v(), middle, 2 * kHalf, refined.first, 0.05, 5, 0.0002, 5);
      if (refined.second < kCorrelationLeast) continue;
      found_.push_back(Grown(middle, refined.first));
    }
  }

  bool IsFound(std::ptrdiff_t middle, double at) const {
    return std::ranges::any_of(found_, [&](const CommonStretch& stretch) {
      const auto k = middle - static_cast<std::ptrdiff_t>(stretch.begin);
      return k >= 0 && k < static_cast<std::ptrdiff_t>(stretch.at.size()) &&
             std::abs(static_cast<double>(stretch.at[static_cast<std::size_t>(k)]) - at) < 2.0;
    });
  }

  std::vector<Place> PlacesOf(double anchor) {
    std::vector<Place> places;
    const std::span<const std::uint64_t> words = known_.words();
    const int steps = static_cast<int>(std::lround(kRateMost / kRateStep));
    for (int step = 0; step <= 2 * steps; ++step) {
      // Nearest to 1 first.
      const double rate = 1.0 + kRateStep * (step % 2 == 0 ? step / 2 : -(step + 1) / 2);
      const std::uint64_t word = WordAt(other_, anchor, rate);
      const int ones = std::popcount(word);
      if (std::min(ones, static_cast<int>(kBits) - ones) < kBitsLeast) continue;
      CountDiffering(word, words, &differing_);
      for (std::size_t at = 0; at < words.size(); ++at) {
        if (differing_[at] > kDifferMost) continue;
        places.push_back({at, rate, static_cast<int>(differing_[at])});
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
      const auto [refined, correlation] =
          Refined(known_.uc_v(), other_.uc_v(), at, kHalf, line, 0.1, 5, 0.0, 0);
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
  std::vector<CommonStretch> found_;
  std::vector<std::uint64_t> differing_;
};

}  // namespace

Command::Command(std::vector<float> uc_v) : uc_v_(std::move(uc_v)), wave_(uc_v_.size()) {
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
  const auto [low, high] = std::ranges::minmax_element(uc_v_);
  still_ = 1e-4F * (*high - *low);
  words_.resize(size - kAnchor + 2);
  for (std::size_t at = 0; at < words_.size(); ++at) {
    for (std::size_t bit = 0; bit < kBits; ++bit) {
      if (wave_[at + 2 * bit] > still_) words_[at] |= std::uint64_t{1} << bit;
    }
  }
}

std::vector<CommonStretch> FindCommon(const Command& known, const Command& other) {
  if (known.words().empty() || other.words().empty()) return {};
  return Finder(known, other).Find();
}

}  // namespace faultlab::core
