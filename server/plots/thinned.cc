#include "server/plots/thinned.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace faultlab::server {
namespace {

constexpr std::size_t kPointsMax = 20'000;
constexpr double kParts = 4000.0;

/// Copies the points [begin, end) that are kept of one part without a gap.
void Keep(const Series& from, std::size_t begin, std::size_t end, Series& to) {
  const auto low_high = std::minmax_element(from.y.begin() + static_cast<std::ptrdiff_t>(begin),
                                            from.y.begin() + static_cast<std::ptrdiff_t>(end));
  const auto low = static_cast<std::size_t>(low_high.first - from.y.begin());
  const auto high = static_cast<std::size_t>(low_high.second - from.y.begin());
  std::size_t kept = end;
  for (const std::size_t at : {begin, std::min(low, high), std::max(low, high), end - 1}) {
    if (at == kept) continue;
    kept = at;
    to.x.push_back(from.x[at]);
    to.y.push_back(from.y[at]);
  }
}

}  // namespace

Series Thinned(Series series, const std::optional<Inset>& whole) {
  const std::size_t size = series.x.size();
  if (size <= kPointsMax) return series;
  const double start = series.x.front();
  const double part_s = (series.x.back() - start) / kParts;
  const auto part_of = [&](std::size_t k) { return std::floor((series.x[k] - start) / part_s); };
  const auto is_gap = [&](std::size_t k) { return !std::isfinite(series.y[k]); };
  const auto is_whole = [&](std::size_t k) {
    return whole && series.x[k] >= whole->x_from && series.x[k] <= whole->x_to;
  };
  const auto go_together = [&](std::size_t a, std::size_t b) {
    if (is_gap(a) || is_gap(b)) return is_gap(a) && is_gap(b);
    return !is_whole(a) && !is_whole(b) && part_of(a) == part_of(b);
  };
  Series thin;
  for (std::size_t begin = 0; begin < size;) {
    std::size_t end = begin + 1;
    while (end < size && go_together(begin, end)) ++end;
    Keep(series, begin, is_gap(begin) ? begin + 1 : end, thin);
    begin = end;
  }
  series.x = std::move(thin.x);
  series.y = std::move(thin.y);
  return series;
}

}  // namespace faultlab::server
