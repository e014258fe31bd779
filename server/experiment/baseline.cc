#include "server/experiment/baseline.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/signals/excitation.h"
#include "server/lab/rig_check.h"

namespace faultlab::server {
namespace {

constexpr double kRichLeast = 0.5;       // of the rms of the bench's usual excitation
constexpr double kTolerancesMost = 4.0;  // from the data sheet
constexpr double kBeyond = 0.05;         // of the span of the input: what a run may go beyond it

double Span(const InputRange& range) {
  return range.high_v - range.low_v;
}

std::optional<double> MeasuredOf(const lab::CheckRecord& check, std::string_view step) {
  for (const lab::CheckStep& each : check.steps) {
    if (each.step == step && each.figure) return each.figure->measured;
  }
  return std::nullopt;
}

}  // namespace

InputRange RangeOf(std::span<const double> uc_v) {
  if (uc_v.empty()) return {};
  const auto [low, high] = std::minmax_element(uc_v.begin(), uc_v.end());
  const auto n = static_cast<double>(uc_v.size());
  double mean = 0.0;
  for (const double u : uc_v) mean += u / n;
  double square = 0.0;
  for (const double u : uc_v) square += (u - mean) * (u - mean) / n;
  return {*low, *high, std::sqrt(square)};
}

InputRange UsualRange(const core::Bench& bench, double duration_s) {
  const auto uc_v = core::Generate(bench.excitation, duration_s, bench.period_s);
  return uc_v ? RangeOf(uc_v.value()) : InputRange{};
}

std::string WhyNoBaseline(const std::string& owner,
                          const InputRange& input,
                          const core::Calibration& calibration,
                          const core::Bench& bench) {
  if (owner.empty() || owner == "guest") return "a guest's";
  const double usual_v = UsualRange(bench, calibration.to_s - calibration.from_s).rms_v;
  if (!(input.rms_v >= kRichLeast * usual_v)) return "learnt with too little movement of the input";
  for (const core::CalibratedQuantity& each : calibration.quantities) {
    if (!each.from_data || !(each.prior_sigma > 0.0)) continue;
    const double away = std::abs(each.value - each.prior_value) / each.prior_sigma;
    if (!(away <= kTolerancesMost)) return each.name + " is outside of the rig's norm";
  }
  return "";
}

bool Covers(const InputRange& learnt, const InputRange& wanted) {
  const double beyond_v = kBeyond * Span(learnt);
  return Span(learnt) > 0.0 && wanted.low_v >= learnt.low_v - beyond_v &&
         wanted.high_v <= learnt.high_v + beyond_v;
}

bool IsConfirmed(const std::vector<lab::CheckRecord>& checks,
                 WallTime since,
                 const core::Calibration& calibration,
                 const core::Bench& bench,
                 double delta_s) {
  const auto newest =
      std::ranges::find_if(checks, [](const auto& check) { return check.kind == "between_users"; });
  if (newest == checks.end() || newest->at <= since || !newest->passed) return false;
  const std::array measured = {
      MeasuredOf(*newest, "b0d"), MeasuredOf(*newest, "gain"), MeasuredOf(*newest, "a1d")};
  if (!measured[0] || !measured[1] || !measured[2]) return false;
  const lab::RigBand band{*measured[0], *measured[1], *measured[2]};
  return lab::IsOfCalibration(band, calibration, bench, delta_s);
}

}  // namespace faultlab::server
