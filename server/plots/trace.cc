#include "server/plots/trace.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

/// Collects the points of one pixel column and passes on those that are visible.
class ColumnThinner {
 public:
  explicit ColumnThinner(std::vector<PixelPoint>& out) : out_(out) {}

  void Add(PixelPoint point) {
    if (!column_.empty() && std::floor(point.x) != std::floor(column_.front().x)) {
      Flush();
    }
    column_.push_back(point);
  }

  void Flush() {
    constexpr std::size_t kKept = 4;
    if (column_.size() <= kKept) {
      out_.insert(out_.end(), column_.begin(), column_.end());
    } else {
      const auto lower = [](const PixelPoint& a, const PixelPoint& b) { return a.y < b.y; };
      const auto [low, high] = std::minmax_element(column_.begin(), column_.end(), lower);
      out_.push_back(column_.front());
      out_.push_back(*std::min(low, high));
      out_.push_back(*std::max(low, high));
      out_.push_back(column_.back());
    }
    column_.clear();
  }

 private:
  std::vector<PixelPoint>& out_;
  std::vector<PixelPoint> column_;
};

}  // namespace

std::vector<std::vector<PixelPoint>> MakeTraces(const Series& series, const PlotScale& scale) {
  LAB_CHECK(series.x.size() == series.y.size(), series.name, series.x.size(), series.y.size());
  std::vector<std::vector<PixelPoint>> traces;
  std::size_t i = 0;
  const std::size_t count = series.x.size();
  const auto usable = [&](std::size_t k) {
    return std::isfinite(series.x[k]) && std::isfinite(series.y[k]);
  };
  while (i < count) {
    if (!usable(i)) {
      ++i;
      continue;
    }
    std::vector<PixelPoint> trace;
    ColumnThinner thinner(trace);
    double level = 0.0;
    for (bool first = true; i < count && usable(i); ++i, first = false) {
      const PixelPoint point = {scale.ToX(series.x[i]), scale.ToY(series.y[i])};
      if (series.stair && !first && point.y != level) {
        thinner.Add({point.x, level});
      }
      level = point.y;
      thinner.Add(point);
    }
    thinner.Flush();
    traces.push_back(std::move(trace));
  }
  return traces;
}

}  // namespace faultlab::server
