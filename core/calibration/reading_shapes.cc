#include "core/calibration/reading_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

// Fewer readings than these tell nothing.
constexpr std::size_t kReadingsMin = 100;
// Of the runs of one number so many are equally long, within a fifth of a row: those of a counter
// are of all lengths.
constexpr double kEqualShare = 0.9;
constexpr double kLengthTolerance = 0.2;
constexpr std::size_t kRunsMin = 10;
// Readings that stand at one number, and hardly ever at the next one to it.
constexpr double kEndShare = 0.02;
constexpr double kBesideNext = 10.0;
// A channel's own end is known: it may be clipped there.
constexpr double kWithin = 0.98;

struct ShapedChannel {
  const char* name;
  const char* unit;
  double Sample::*reading;
  BenchChannel Bench::*spec;
};
constexpr std::array<ShapedChannel, 3> kShapedChannels = {
    {{"um", "V", &Sample::um_v, &Bench::um},
     {"ia", "A", &Sample::ia_a, &Bench::ia},
     {"n", "rpm", &Sample::n_rpm, &Bench::n}}};

std::vector<double> ReadingsOfChannel(std::span<const Sample> samples, double Sample::*reading) {
  std::vector<double> readings;
  for (const Sample& sample : samples) {
    if (std::isfinite(sample.*reading)) readings.push_back(sample.*reading);
  }
  return readings;
}

/// How often the outermost number is read, if that is an end: no number beside it is read as often.
struct End {
  double value = 0.0;
  double share = 0.0;
};

std::optional<End> EndOf(const std::map<double, std::size_t>& counts, std::size_t all, bool upper) {
  if (counts.size() < kRunsMin) return std::nullopt;
  const auto outermost = upper ? std::prev(counts.end()) : counts.begin();
  const auto next = upper ? std::prev(outermost) : std::next(outermost);
  const double times = static_cast<double>(outermost->second);
  const double share = times / static_cast<double>(all);
  // A motor that stands still reads 0 again and again.
  if (outermost->first == 0.0 || share < kEndShare) return std::nullopt;
  if (times < kBesideNext * static_cast<double>(next->second)) return std::nullopt;
  return End{outermost->first, share};
}

}  // namespace

int HeldRows(std::span<const double> readings) {
  std::vector<std::size_t> runs;
  for (std::size_t from = 0; from < readings.size();) {
    std::size_t to = from + 1;
    while (to < readings.size() && readings[to] == readings[from]) ++to;
    runs.push_back(to - from);
    from = to;
  }
  if (readings.size() < kReadingsMin || runs.size() < kRunsMin) return 1;
  std::vector<std::size_t> sorted = runs;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const std::size_t usual = *middle;
  const auto tolerance = static_cast<std::size_t>(kLengthTolerance * static_cast<double>(usual));
  const auto equal = std::ranges::count_if(runs, [&](std::size_t length) {
    return length + tolerance >= usual && length <= usual + tolerance;
  });
  const bool regular = static_cast<double>(equal) >= kEqualShare * static_cast<double>(runs.size());
  return usual > 1 && regular ? static_cast<int>(usual) : 1;
}

std::optional<Error> CheckShapes(const Bench& bench,
                                 std::span<const Sample> samples,
                                 unsigned mask) {
  for (std::size_t i = 0; i < kShapedChannels.size(); ++i) {
    if (((mask >> i) & 1U) == 0U) continue;
    const ShapedChannel& channel = kShapedChannels[i];
    const std::vector<double> readings = ReadingsOfChannel(samples, channel.reading);
    if (readings.size() < kReadingsMin) continue;
    const auto refuse = [&](const char* check, const std::string& sentence) {
      return Error{ErrorCode::kInvalid,
                   std::string("not calibrated, check '") + check + "' failed: " + channel.name +
                       " " + sentence,
                   check};
    };
    if (const int rows = HeldRows(readings); rows > 1) {
      return refuse("repeats",
                    Format("reads the same number %d rows long: leave the repeated cells empty, so "
                           "that each reading stands once",
                           rows));
    }
    std::map<double, std::size_t> counts;
    for (const double reading : readings) ++counts[reading];
    std::string ends;
    double share = 0.0;
    for (const bool upper : {true, false}) {
      const std::optional<End> end = EndOf(counts, readings.size(), upper);
      const BenchChannel& spec = bench.*channel.spec;
      const double stated = upper ? spec.max : spec.min;
      if (!end || std::abs(end->value) > kWithin * std::abs(stated)) continue;
      ends += (ends.empty() ? "" : " and ") + Format("%.4g ", end->value) + channel.unit;
      share += end->share;
    }
    if (!ends.empty()) {
      return refuse(
          "range",
          "stands at " + ends +
              Format(" in %.2g %% of the samples: is that the end of its range? Record it "
                     "with a wider one, or state it in the description of the bench",
                     100.0 * share));
    }
  }
  return std::nullopt;
}

}  // namespace faultlab::core
