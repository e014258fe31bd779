#include "hardware/device/device_check.h"

#include <cmath>
#include <string>

#include "core/types/number_text.h"
#include "hardware/io_error.h"
#include "hardware/relay_board.h"

namespace faultlab::hardware {
namespace {

std::string Milliseconds(double us) {
  return core::Format("%.4g ms", us * 1e-3);
}

void Compare(const char* what, std::uint32_t of_device, std::uint32_t described) {
  if (of_device == described) return;
  throw IoError(std::string("the device has ") + what + " " + Hex(of_device) +
                ", the description of the bench " + Hex(described) +
                ": correct the device's configuration (board_config.h) or the description");
}

std::uint32_t MakeFirstLines(const RelayWiring& wiring) {
  std::uint32_t lines = 0;
  for (const core::Component board : wiring.boards) {
    if (board.info().order != core::SwitchOrder::kMakeBeforeBreak) continue;
    for (const core::SwitchPosition& position : board.info().positions) {
      lines |= 1u << position.line;
    }
  }
  return lines;
}

double CodeOf(const DeviceInfo& info, const BenchConfig& config, double uc_v) {
  const double volt = config.scaling.uc.ToTerminal(uc_v);
  return std::round(volt / (info.uc.step_nv * 1e-9)) + info.uc.offset;
}

core::Error Refused(std::string message, std::string field) {
  return {
      .code = core::ErrorCode::kInvalid, .message = std::move(message), .field = std::move(field)};
}

}  // namespace

void CheckWiringOf(const DeviceInfo& info, BenchConfig& config, std::uint32_t nominal_lines) {
  Compare("relay lines", info.relay_lines, config.wiring.mask());
  Compare("the safe lines", info.safe_lines, nominal_lines);
  Compare(
      "lines that make before they break", info.make_first_lines, MakeFirstLines(config.wiring));
  const auto has = [&](std::uint16_t capability) { return (info.capabilities & capability) != 0; };
  if (config.description.has_um && !has(DeviceInfo::kUm)) {
    throw IoError("the device does not measure um: without it there is nothing to diagnose");
  }
  for (const DeviceChannel* channel : {&info.uc, &info.um}) {
    if (channel->step_nv == 0)
      throw IoError("the device says that a code is 0 V: correct its INFO");
  }
  RigDescription& rig = config.description;
  rig.has_ua = rig.has_ua && has(DeviceInfo::kUa);
  rig.has_ia = rig.has_ia && has(DeviceInfo::kIa);
  rig.has_n = rig.has_n && has(DeviceInfo::kEncoder);
  if (!has(DeviceInfo::kEdgeTime)) config.scaling.speed = SpeedMethod::kGatedCount;
}

core::Status CheckPlanOf(const DeviceInfo& info, const BenchConfig& config, const RunPlan& plan) {
  const double period_us = plan.period_s * 1e6;
  if (period_us < info.period_min_us || period_us > info.period_max_us) {
    return Refused("the device takes periods from " + Milliseconds(info.period_min_us) + " to " +
                       Milliseconds(info.period_max_us),
                   "period_s");
  }
  const double delta_us = config.description.delta_s * 1e6;
  if (delta_us + info.convert_us / 2.0 >= period_us) {
    return Refused("the conversions at delta = " + Milliseconds(delta_us) + " take " +
                       Milliseconds(info.convert_us) + " and would not end within the period",
                   "period_s");
  }
  for (std::size_t k = 0; k < plan.uc_v.size(); ++k) {
    const double code = CodeOf(info, config, plan.uc_v[k]);
    if (code < info.uc_min || code > info.uc_max) {
      return Refused(
          "uc at sample " + std::to_string(k) + " is more than the device's converter puts out",
          "uc_v/" + std::to_string(k));
    }
  }
  return core::Done{};
}

std::vector<std::int16_t> CodesOf(const DeviceInfo& info,
                                  const BenchConfig& config,
                                  const RunPlan& plan) {
  std::vector<std::int16_t> codes;
  codes.reserve(plan.uc_v.size());
  for (const double uc_v : plan.uc_v) {
    codes.push_back(static_cast<std::int16_t>(CodeOf(info, config, uc_v)));
  }
  return codes;
}

}  // namespace faultlab::hardware
