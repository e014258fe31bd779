#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hardware/loop_quality.h"

namespace faultlab::server {

/// {name="value"}; the value is escaped.
std::string Label(std::string_view name, std::string_view value);

/// The Prometheus text format. Lines of one name must come one after the other: the TYPE line goes
/// before the first of them.
class MetricsText {
 public:
  void Add(std::string_view name,
           std::string_view type,
           std::uint64_t value,
           const std::string& labels = {});
  /// name_bucket{..,le=".."} cumulative, name_sum, name_count. `name` is in seconds.
  void AddHistogram(const std::string& name,
                    const hardware::TimeHistogram& histogram,
                    const std::string& labels);
  std::string Take() { return std::move(text_); }

 private:
  void Head(std::string_view name, std::string_view type);

  std::string text_;
  std::string last_;
};

}  // namespace faultlab::server
