#include "server/diagnosis_json/channel_ranges.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numerics/statistics.h"
#include "core/types/number_text.h"

namespace faultlab::server {
namespace {

constexpr double kShare = 0.95;
constexpr double kNoted = 1.5;  // times the range: benches of a class differ
constexpr double kImpossible = 10.0;
constexpr double kUsed = 0.05;  // of the range, at least, by a record in the right unit

struct Column {
  std::string_view name;
  std::string_view unit;
  double core::Sample::*member;
  bool exists;
  double min;
  double max;
};

/// A unit in which the same numbers would lie within the range.
struct OtherUnit {
  std::string_view name;
  std::string_view of;
  double factor;
};
constexpr std::array<OtherUnit, 3> kOtherUnits = {
    {{"mV", "V", 1e-3}, {"mA", "A", 1e-3}, {"deg/s", "rpm", 1.0 / 6.0}}};

std::string Rounded(double value) {
  return core::Format("%.4g", value);
}

double UsualSize(std::span<const core::Sample> samples, double core::Sample::*member) {
  std::vector<double> sizes;
  for (const core::Sample& sample : samples) {
    if (std::isfinite(sample.*member)) sizes.push_back(std::abs(sample.*member));
  }
  return sizes.empty() ? 0.0 : core::Quantile(std::move(sizes), kShare);
}

std::string LikelyUnit(const Column& column, double size, double limit) {
  for (const OtherUnit& unit : kOtherUnits) {
    const double there = size * unit.factor;
    if (unit.of == column.unit && there <= kNoted * limit && there >= kUsed * limit) {
      return std::string(unit.name);
    }
  }
  return {};
}

}  // namespace

core::Result<std::vector<std::string>> NotesOnRanges(std::span<const core::Sample> samples,
                                                     const core::Bench& bench,
                                                     std::string_view file) {
  const auto measured = [](std::string_view name,
                           std::string_view unit,
                           double core::Sample::*member,
                           const core::BenchChannel& channel) {
    return Column{name, unit, member, channel.exists, channel.min, channel.max};
  };
  const std::array<Column, 5> columns = {
      {{"uc_v", "V", &core::Sample::uc_v, true, bench.input_min_v, bench.input_max_v},
       measured("um_v", "V", &core::Sample::um_v, bench.um),
       measured("ua_v", "V", &core::Sample::ua_v, bench.ua),
       measured("ia_a", "A", &core::Sample::ia_a, bench.ia),
       measured("n_rpm", "rpm", &core::Sample::n_rpm, bench.n)}};
  std::vector<std::string> notes;
  for (const Column& column : columns) {
    const double limit = std::max(std::abs(column.min), std::abs(column.max));
    const double size = column.exists ? UsualSize(samples, column.member) : 0.0;
    if (!(limit > 0.0) || size <= kNoted * limit) continue;
    const std::string likely = LikelyUnit(column, size, limit);
    const std::string said = std::string(column.name) + " of " + Rounded(size) + " " +
                             std::string(column.unit) + " is beyond " + Rounded(column.min) +
                             " to " + Rounded(column.max) + " " + std::string(column.unit) +
                             " of the bench " + bench.name +
                             (likely.empty() ? ": is it another quantity, or of another bench?"
                                             : ": is the unit " + likely + "?");
    if (size > kImpossible * limit) {
      return core::Error{core::ErrorCode::kInvalid,
                         std::string(file) + ": " + said,
                         std::string(column.name),
                         "value_beyond_range",
                         {{"column", std::string(column.name)},
                          {"value", Rounded(size) + " " + std::string(column.unit)},
                          {"range", Rounded(column.min) + " .. " + Rounded(column.max)}}};
    }
    notes.push_back(std::string(file) + ": " + said);
  }
  return notes;
}

}  // namespace faultlab::server
