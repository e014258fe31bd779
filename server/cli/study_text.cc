#include "server/cli/study_text.h"

#include <algorithm>
#include <cmath>

#include "core/types/number_text.h"

namespace faultlab::server {
namespace {

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

std::string LeftCells(const core::OrderEvidence& left) {
  const char* white = !std::isfinite(left.ljung_box) ? "-" : left.white() ? "yes" : "no";
  return Cell(left.rms, 10, 4) + Cell(left.ljung_box, 10, 4) + core::Format("%7s", white) +
         Cell(left.bic, 10, 6);
}

/// What each model leaves of the readings.
std::string OrdersText(const WindowStudy& study) {
  const bool changed = study.change_s.has_value();
  const auto unknown = [](int order) { return order == 0 ? "-" : std::to_string(order); };
  std::string out = "\n" + PadRight("  window", 20) + "   left, rms Ljung-Box  white       BIC";
  out += changed ? "     after Ljung-Box  white       BIC\n" : "\n";
  for (const WindowStudyRow& row : study.rows) {
    out += PadRight("  " + row.name, 20) + "  " + LeftCells(row.left_before) +
           (changed ? LeftCells(row.left_after) : "") + '\n';
  }
  out += "\n";
  for (const WindowStudyRow& row : study.rows) {
    const auto first = std::ranges::find_if(study.rows, [&](const WindowStudyRow& each) {
      return core::DifferInOrderAlone(each.spec, row.spec);
    });
    if (&*first != &row) continue;
    const std::string window = row.spec.integral_samples == 0
                                   ? "SWA, K = " + std::to_string(row.spec.window_samples)
                                   : "SIA, K:m = " + std::to_string(row.spec.window_samples) + ":" +
                                         std::to_string(row.spec.integral_samples);
    out +=
        "  " + PadRight(window + ":", 24) + "order " + unknown(study.OrderFor(row, false)) +
        (changed ? " before the change, " + unknown(study.OrderFor(row, true)) + " after it" : "") +
        "\n";
  }
  return out +
         "\n  What is left is each reading less what the model says from those before it. White: a"
         "\n  higher order has nothing more to explain (noise of the sensor wants orders, too). "
         "Least"
         "\n  BIC: the order that is worth its parameters.\n";
}

}  // namespace

std::string StudyText(const WindowStudy& study, const std::string& file) {
  constexpr std::size_t kNameWidth = 20;
  constexpr std::size_t kParameterWidth = 8;
  const bool changed = study.change_s.has_value();
  std::string out =
      file + ": " + std::to_string(study.samples) + " samples of " + Cell(study.period_s, 0) +
      " s, studied from " + Cell(study.from_s, 0) + " s on, " +
      (changed ? "change at " + Cell(*study.change_s, 0) + " s" : std::string("no change")) +
      (study.until_s ? ", to the next one at " + Cell(*study.until_s, 0) + " s" : "") + "\n\n";
  out += PadRight("  window", kNameWidth) + PadRight("", kParameterWidth) +
         "    before     +-sd  (sigma)";
  out += changed ? "     after     +-sd  (sigma)  settles" : "";
  out += "  not excited\n";
  for (const WindowStudyRow& row : study.rows) {
    for (std::size_t j = 0; j < row.parameters.size(); ++j) {
      out += PadRight(j == 0 ? "  " + row.name : std::string(), kNameWidth) +
             PadRight(row.parameters[j], kParameterWidth) + Cells(row.before[j]);
      if (changed) {
        out += Cells(row.after[j]);
      }
      if (j == 0) {
        if (changed) {
          out += Cell(row.settling_samples * study.period_s, 7, 3) + " s";
        }
        out += Cell(100.0 * row.unexcited_share, 11, 3) + " %";
      }
      out += '\n';
    }
  }
  out +=
      "\n  +-sd is how far the settled estimates spread, sigma the standard error that they state."
      "\n  A short window settles sooner, a long one spreads less.\n";
  for (const std::string& name : study.left_out) {
    out += "  " + name + " is left out: too few samples for it.\n";
  }
  const bool orders = std::ranges::any_of(study.rows, [&](const WindowStudyRow& row) {
    return row.spec.order != study.rows.front().spec.order;
  });
  return orders ? out + OrdersText(study) : out;
}

}  // namespace faultlab::server
