#include "server/cli/control.h"

#include <array>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <optional>
#include <utility>

#include "core/control/closed_loop/control_run.h"
#include "core/isolability/isolability.h"
#include "core/types/number_text.h"
#include "hardware/bench/benches.h"
#include "hardware/rig_limits.h"
#include "server/cli/console.h"
#include "server/csv/fault_text.h"
#include "server/csv/file_io.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using core::Result;

constexpr std::array kControllers = {
    core::ControlKind::kNominal, core::ControlKind::kCompensated, core::ControlKind::kRobust};

Error Refused(std::string message, std::string field) {
  return {ErrorCode::kInvalid, std::move(message), std::move(field), "internal"};
}

Result<core::ControlPlan> ControlPlanOf(const ControlCommandOptions& options) {
  TRY(const auto bench, hardware::LoadBench(options.bench));
  core::ControlPlan plan;
  plan.bench = bench;
  plan.reference.hold_s = options.hold_s;
  plan.duration_s = options.duration_s;
  plan.seed = options.seed;
  const auto kind = core::ParseControlKind(options.controller);
  if (!kind) {
    return Refused(
        "--controller '" + options.controller + "': expected nominal, compensated or robust",
        "controller");
  }
  plan.options.kind = *kind;
  const auto shape = core::ParseReferenceShape(options.shape);
  if (!shape) {
    return Refused("--shape '" + options.shape + "': expected steps, ramp or prbs", "shape");
  }
  plan.reference.shape = *shape;
  const std::size_t colon = options.reference.find(':');
  const auto low = core::ParseNumber(options.reference.substr(0, colon));
  const auto high =
      colon == std::string::npos ? low : core::ParseNumber(options.reference.substr(colon + 1));
  if (!low || !high) {
    return Refused(
        "--reference '" + options.reference + "': expected LOW:HIGH in rad/s, for example 150:170",
        "reference");
  }
  plan.reference.low_rad_s = *low;
  plan.reference.high_rad_s = *high;
  for (const std::string& text : options.faults) {
    TRY(auto fault, ParseFault(text, *plan.bench));
    plan.faults.push_back(fault);
  }
  if (!options.told.empty()) {
    TRY(plan.told, ParseFault(options.told, *plan.bench));
  }
  return plan;
}

std::string Short(double value, int digits) {
  return core::Format("%.*g", digits, value);
}

/// What would have ended the run of a real rig.
std::optional<hardware::Trip> TripOf(const core::ControlRecord& record, const core::Bench& bench) {
  hardware::Interlocks interlocks(bench.limits);
  for (const core::Sample& sample : record.samples) {
    if (auto trip = interlocks.Check(sample, bench.period_s)) return trip;
  }
  return std::nullopt;
}

std::string JsonOf(const core::ControlRecord& record, const core::Bench& bench) {
  const core::ControlQuality& quality = record.quality;
  const std::optional<hardware::Trip> trip = TripOf(record, bench);
  return json::serialize(json::object{{"iae", quality.iae_rad},
                                      {"late_iae", quality.late_iae_rad},
                                      {"overshoot_percent", quality.overshoot_percent},
                                      {"settling_s", NumberOrNull(quality.settling_s)},
                                      {"steady_error_rad_s", quality.steady_error_rad_s},
                                      {"compensated_at_s", NumberOrNull(record.compensated_at_s)},
                                      {"gave_up_at_s", NumberOrNull(record.gave_up_at_s)},
                                      {"accommodated", record.accommodated},
                                      {"dither_rad_s", record.dither_rad_s},
                                      {"reachable_rad_s", record.reachable_rad_s},
                                      {"trip", trip ? json::value(trip->name) : nullptr},
                                      {"trip_at_s", trip ? json::value(trip->t_s) : nullptr}}) +
         "\n";
}

std::string TextOf(const core::ControlRecord& record, const core::Bench& bench) {
  const core::ControlQuality& quality = record.quality;
  std::string out = "  IAE           " + Short(quality.iae_rad, 3) + " rad, of it " +
                    Short(quality.late_iae_rad, 3) + " later than two holds\n";
  out += "  overshoot     " + Short(quality.overshoot_percent, 3) + " %\n";
  out += "  settling      " +
         (quality.settling_s ? Short(*quality.settling_s, 3) + " s" : "not within the run") + "\n";
  out += "  steady error  " + Short(quality.steady_error_rad_s, 3) + " rad/s\n";
  if (const auto trip = TripOf(record, bench)) {
    out += "  trips         at " + Short(trip->t_s, 4) + " s: " + trip->name +
           ". A real rig ends its run there; these figures exist on none\n";
  }
  if (record.compensated_at_s) {
    out += "  dither        " + Short(record.dither_rad_s, 2) +
           " rad/s rms between the alarm and the compensation\n";
    out += "  compensated   from " + Short(*record.compensated_at_s, 5) + " s\n";
  }
  if (record.gave_up_at_s) {
    out += "  given up      at " + Short(*record.gave_up_at_s, 5) +
           " s: the speed refutes the diagnosis\n";
  }
  out += "  verdict       " + std::string(core::Name(record.verdict.kind)) +
         (record.verdict.reason.empty() ? "" : ": " + record.verdict.reason) + "\n";
  if (!record.accommodated) {
    out += "  refused       the rig reaches " + Short(record.reachable_rad_s, 4) +
           " rad/s with this fault: lower the reference\n";
  }
  return out;
}

std::string CellOf(const core::ControlRecord& record, const core::Bench& bench) {
  const core::ControlQuality& quality = record.quality;
  const auto trip = TripOf(record, bench);
  return (trip ? "(" + trip->name + " at " + Short(trip->t_s, 3) + " s) " : std::string()) +
         Short(quality.iae_rad, 3) + " / " + Short(quality.late_iae_rad, 3) + " / " +
         Short(quality.overshoot_percent, 2) + " / " +
         (quality.settling_s ? Short(1e3 * *quality.settling_s, 3) : "never") + " / " +
         Short(quality.steady_error_rad_s, 2);
}

/// One row for the healthy rig and for every value that the bench offers of every component.
Result<std::string> TableOf(core::ControlPlan plan) {
  std::string table =
      "# Control that tolerates the fault\n\n"
      "Written by `faultlab control --markdown`: a simulated rig of the bench " +
      plan.bench->name + ", the reference " + Short(plan.reference.low_rad_s, 4) + " and " +
      Short(plan.reference.high_rad_s, 4) + " rad/s in turn, the fault at 10 s of " +
      Short(plan.duration_s, 3) +
      " s. From the fault on: IAE (rad) / of it later than two holds / overshoot (%) / settling "
      "after the last step (ms) / steady error (rad/s). A real rig ends its run where an interlock "
      "trips, in brackets: what is told of it then exists on no rig.\n\n"
      "| fault | nominal | compensated | robust | compensated from (s) | reaches (rad/s) |\n"
      "|---|---|---|---|---|---|\n";
  std::vector<std::vector<core::Fault>> cases = {{}};
  for (const core::FaultSize& fault : core::FaultsOf(*plan.bench)) {
    cases.push_back({{fault.component, fault.value, 10.0}});
  }
  for (const std::vector<core::Fault>& faults : cases) {
    plan.faults = faults;
    std::string row =
        "| " + (faults.empty() ? std::string("none") : FormatFault(faults.front())) + " ";
    std::string rest;
    for (const core::ControlKind kind : kControllers) {
      plan.options.kind = kind;
      TRY(const auto record, core::RunControl(plan));
      row += "| " + CellOf(record, *plan.bench) + " ";
      if (kind != core::ControlKind::kCompensated) continue;
      const auto& at_s = record.compensated_at_s;
      rest = "| " + (at_s ? Short(*at_s, 5) : std::string("-")) + " | " +
             Short(record.reachable_rad_s, 4) + (record.accommodated ? " |\n" : ", refused |\n");
    }
    table += row + rest;
  }
  return table;
}

}  // namespace

int RunControlCommand(const ControlCommandOptions& options) {
  TRY_INPUT(auto plan, ControlPlanOf(options));
  if (!options.markdown.empty()) {
    TRY_INPUT(const auto table, TableOf(std::move(plan)));
    return Ended(WriteFile(options.markdown, table));
  }
  TRY_INPUT(const auto record, core::RunControl(plan));
  return Print(options.json ? JsonOf(record, *plan.bench) : TextOf(record, *plan.bench));
}

}  // namespace faultlab::server
