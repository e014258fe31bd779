#include "server/experiment/control_json.h"

#include <algorithm>
#include <boost/json/parse.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "core/control/closed_loop/orders.h"
#include "server/json/json_reader.h"
#include "server/json/kept_json.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr double kSpeedMaxRadS = 1e5;
// Of the speed that the bench reaches: well below what a weak amplifier leaves.
constexpr double kLowShare = 0.33;
constexpr double kHighShare = 0.375;

double TwoDigits(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::round(value / unit) * unit;
}

}  // namespace

core::SpeedReference UsualReference(const core::Bench& bench) {
  const double reachable = core::DescribedDrive(bench, bench.period_s).reachable_rad_s();
  core::SpeedReference reference;
  reference.low_rad_s = TwoDigits(kLowShare * reachable);
  reference.high_rad_s = TwoDigits(kHighShare * reachable);
  return reference;
}

core::Result<WantedControl> ParseControl(const json::object& object,
                                         const core::Bench& bench,
                                         double period_s) {
  ObjectReader in(object, "/control");
  WantedControl control;
  control.reference = UsualReference(bench);
  control.options.kind = *core::ParseControlKind(
      in.WordOr("controller", "compensated", {"nominal", "compensated", "robust"}));
  control.options.dither_v =
      in.NumberOr("dither_v", control.options.dither_v, 0.0, core::ToleranceOptions::kDitherMaxV);
  if (const json::object* wanted = in.ObjectOrNull("reference")) {
    ObjectReader of(*wanted, "/control/reference");
    core::SpeedReference& reference = control.reference;
    reference.shape =
        *core::ParseReferenceShape(of.WordOr("shape", "steps", {"steps", "ramp", "prbs"}));
    reference.low_rad_s = of.NumberOr("low_rad_s", reference.low_rad_s, 0.0, kSpeedMaxRadS);
    reference.high_rad_s = of.NumberOr("high_rad_s", reference.high_rad_s, 0.0, kSpeedMaxRadS);
    reference.hold_s = of.NumberOr("hold_s", reference.hold_s, 0.0, kRunSecondsMax);
    if (auto error = of.Finish()) return *error;
  }
  if (auto error = in.Finish()) return *error;
  const core::Status possible = core::Validate(control.reference, period_s);
  if (!possible.ok()) {
    return refusal::At(possible.error(), "/control/reference/" + possible.error().field);
  }
  return control;
}

json::object ToJson(const WantedControl& control) {
  const core::SpeedReference& reference = control.reference;
  return {{"reference",
           {{"shape", core::Name(reference.shape)},
            {"low_rad_s", reference.low_rad_s},
            {"high_rad_s", reference.high_rad_s},
            {"hold_s", reference.hold_s}}},
          {"controller", core::Name(control.options.kind)},
          {"dither_v", control.options.dither_v}};
}

std::optional<PlannedControl> ControlOfPlan(std::string_view plan_json,
                                            const core::Bench& bench,
                                            double period_s) {
  const json::value plan = ParsedOr(plan_json);
  const json::value* control = MemberIn(plan, "control");
  if (control == nullptr || !control->is_object()) return std::nullopt;
  json::object as_wanted = control->get_object();
  PlannedControl planned;
  if (const json::value* from = as_wanted.if_contains("from_s"); from != nullptr) {
    planned.from_s = from->is_number() ? from->to_number<double>() : 0.0;
  }
  if (const json::value* profile = as_wanted.if_contains("profile"); profile != nullptr) {
    if (profile->is_string()) planned.profile = std::string(profile->get_string());
  }
  as_wanted.erase("from_s");
  as_wanted.erase("profile");
  auto wanted = ParseControl(as_wanted, bench, period_s);
  if (!wanted) return std::nullopt;
  planned.wanted = std::move(wanted).value();
  return planned;
}

ReferenceCorners CornersOf(const PlannedControl& planned,
                           const core::Bench& bench,
                           double period_s,
                           double duration_s) {
  const core::SpeedReference& reference = planned.wanted.reference;
  const core::ReferencePlayer player(reference, period_s);
  const double rad_per_s = core::RadPerSecondOfRpm(bench.nominal.gear_ratio);
  const auto from = static_cast<std::size_t>(std::lround(planned.from_s / period_s));
  const auto end = static_cast<std::size_t>(std::lround(duration_s / period_s));
  const bool ramp = reference.shape == core::SpeedReference::Shape::kRamp;
  ReferenceCorners corners;
  const auto corner = [&](std::size_t sample, std::size_t tick) {
    corners.t_s.push_back(static_cast<double>(sample) * period_s);
    corners.n_rpm.push_back(player.At(tick) / rad_per_s);
  };
  for (std::size_t k = from; k < end; k += player.hold_ticks()) {
    const std::size_t next = std::min(k + player.hold_ticks(), end);
    corner(k, k - from);
    corner(next, ramp ? next - from : k - from);
  }
  return corners;
}

json::value ControlOf(const core::Bench& bench) {
  const double reachable = core::DescribedDrive(bench, bench.period_s).reachable_rad_s();
  if (!bench.n.exists || !(reachable > 0.0) || !std::isfinite(reachable)) return nullptr;
  const core::SpeedReference usual = UsualReference(bench);
  return json::object{{"reachable_rad_s", reachable},
                      {"low_rad_s", usual.low_rad_s},
                      {"high_rad_s", usual.high_rad_s},
                      {"hold_s", usual.hold_s}};
}

}  // namespace faultlab::server
