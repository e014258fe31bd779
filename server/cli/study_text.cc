#include "server/cli/study_text.h"

#include <algorithm>
#include <boost/json/array.hpp>
#include <cmath>
#include <utility>

#include "core/types/number_text.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Spread;
using core::WindowStudyRow;

std::string Cell(double value, int width, int digits = 4) {
  if (!std::isfinite(value)) return core::Format("%*s", width, "-");
  return core::Format("%*.*g", width, digits, value);
}

std::string PadRight(std::string text, std::size_t width) {
  text.resize(std::max(text.size(), width), ' ');
  return text;
}

std::string Cells(const Spread& spread) {
  constexpr int kWide = 10;
  constexpr int kNarrow = 9;
  return Cell(spread.mean, kWide) + Cell(spread.standard_deviation, kNarrow, 2) +
         Cell(spread.reported_sigma, kNarrow, 2);
}

json::object SpreadJson(const Spread& spread) {
  return {{"mean", NumberOrNull(spread.mean)},
          {"sd", NumberOrNull(spread.standard_deviation)},
          {"sigma", NumberOrNull(spread.reported_sigma)}};
}

}  // namespace

std::string StudyText(const std::vector<WindowStudyRow>& rows, const StudySettings& settings) {
  constexpr std::size_t kNameWidth = 20;
  constexpr std::size_t kParameterWidth = 8;
  const bool changed = settings.change_s.has_value();
  std::string out =
      settings.name + ": " + std::to_string(settings.samples) + " samples of " +
      Cell(settings.period_s, 0) + " s, studied from " + Cell(settings.from_s, 0) + " s on, " +
      (changed ? "change at " + Cell(*settings.change_s, 0) + " s" : std::string("no change")) +
      "\n\n";
  out += PadRight("  window", kNameWidth) + PadRight("", kParameterWidth) +
         "    before     +-sd  (sigma)";
  out += changed ? "     after     +-sd  (sigma)  settles" : "";
  out += "  not excited\n";
  for (const WindowStudyRow& row : rows) {
    for (std::size_t j = 0; j < row.parameters.size(); ++j) {
      out += PadRight(j == 0 ? "  " + row.name : std::string(), kNameWidth) +
             PadRight(row.parameters[j], kParameterWidth) + Cells(row.before[j]);
      if (changed) {
        out += Cells(row.after[j]);
      }
      if (j == 0) {
        if (changed) {
          out += Cell(row.settling_samples * settings.period_s, 7, 3) + " s";
        }
        out += Cell(100.0 * row.unexcited_share, 11, 3) + " %";
      }
      out += '\n';
    }
  }
  out +=
      "\n  +-sd is how far the settled estimates spread, sigma the standard error that they state."
      "\n  A short window settles sooner, a long one spreads less.\n";
  return out;
}

json::object StudyJson(const std::vector<WindowStudyRow>& rows, const StudySettings& settings) {
  json::array variants;
  for (const WindowStudyRow& row : rows) {
    json::array parameters;
    for (std::size_t j = 0; j < row.parameters.size(); ++j) {
      const bool changed = !row.after.empty();
      parameters.push_back(
          json::object{{"name", row.parameters[j]},
                       {"before", SpreadJson(row.before[j])},
                       {"after", changed ? json::value(SpreadJson(row.after[j])) : nullptr}});
    }
    const double settling_s =
        row.settling_samples < 0 ? core::kAbsent : row.settling_samples * settings.period_s;
    variants.emplace_back(
        json::object{{"name", row.name},
                     {"method", row.spec.method == core::EstimatorMethod::kSwa ? "swa" : "sia"},
                     {"order", row.spec.order},
                     {"window", row.spec.window_samples},
                     {"integral", row.spec.integral_samples},
                     {"transient_s", NumberOrNull(row.transient_samples * settings.period_s)},
                     {"settling_s", NumberOrNull(settling_s)},
                     {"unexcited_share", NumberOrNull(row.unexcited_share)},
                     {"parameters", std::move(parameters)}});
  }
  return {{"file", settings.name},
          {"samples", settings.samples},
          {"period_s", settings.period_s},
          {"from_s", settings.from_s},
          {"change_s", NumberOrNull(settings.change_s)},
          {"variants", std::move(variants)}};
}

}  // namespace faultlab::server
