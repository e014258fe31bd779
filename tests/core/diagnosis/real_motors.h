#pragma once

// Motors with physics that the model lacks, on benches of 100 Hz.
#include <string>
#include <vector>

#include "core/diagnosis/pipeline.h"
#include "hardware/bench/benches.h"
#include "tests/core/diagnosis/motor_rig.h"

namespace faultlab::core {

inline const Bench& GearMotor(bool with_um) {
  std::string text = hardware::LoadBench("gear-motor").value()->text;
  if (with_um) {
    const std::string ia = "[channel.ia]";
    text.replace(text.find(ia),
                 ia.size(),
                 "[channel.um]\nnoise = 10e-3\nrange = [-15.0, 15.0]\n[channel.ia]");
  }
  return *hardware::KeepBench(text, "gear.toml").value();
}

/// The published bench as somebody has built it.
inline const Bench& BuiltPaperBench() {
  std::string text = hardware::PaperBench().text;
  const std::string norm = "[norm]\n";
  text.insert(text.find(norm) + norm.size(), "missing_physics = true\n");
  return *hardware::KeepBench(text, "built.toml").value();
}

/// A bench, and a rig of it as it is.
struct Setting {
  const char* name;
  const Bench* bench;
  Rig rig;
};

inline std::vector<Setting> Settings() {
  const Rig gear = {.period_s = 0.01,
                    .delta_s = 0.009,
                    .k = 2.4,
                    .rs = 0.0,
                    .ra = 6.1,
                    .la = 2.5e-3,
                    .ke = 0.0109,
                    .kt = 0.0109,
                    .j = 1.55e-6,
                    .b = 1.0e-6,
                    .mc = 0.9e-3,
                    .supply_min_v = 0.0,
                    .supply_max_v = 12.0,
                    .low_v = 1.5,
                    .high_v = 4.5,
                    .clock = 12,
                    .ia_noise = 0.015,
                    .ia_max = 5.0,
                    .n_noise = 0.5,
                    .has_um = false,
                    .friction_noise_nm = 0.03e-3,
                    .gear = 34.0,
                    .physics = {}};
  Rig with_um = gear;
  with_um.has_um = true;
  const Rig paper = {.period_s = 0.01,
                     .delta_s = 0.0095,
                     .k = 2.42,
                     .rs = 1.0,
                     .ra = 7.6,
                     .la = 0.77e-3,
                     .ke = 0.0252,
                     .kt = 0.0252,
                     .j = 1.48e-6,
                     .b = 1.9e-6,
                     .mc = 1.0e-3,
                     .supply_min_v = -30.0,
                     .supply_max_v = 30.0,
                     .low_v = 1.5,
                     .high_v = 4.0,
                     .clock = 5,
                     .ia_noise = 0.001,
                     .ia_max = 5.0,
                     .n_noise = 0.5,
                     .has_um = true,
                     .friction_noise_nm = 0.02e-3,
                     .gear = 3.8,
                     .physics = {}};
  return {{"gear", &GearMotor(false), gear},
          {"gear+um", &GearMotor(true), with_um},
          {"paper", &BuiltPaperBench(), paper}};
}

/// Also those that were withdrawn.
inline int AlarmsRaised(const std::vector<Sample>& record, const DiagnosisOptions& options) {
  Pipeline pipeline(options);
  int raised = 0;
  bool before = false;
  for (const Sample& sample : record) {
    pipeline.Push(sample);
    const bool now = pipeline.verdict().kind != VerdictKind::kNominal;
    raised += now && !before;
    before = now;
    while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
  }
  return raised;
}

struct PhysicsKind {
  const char* name;
  Physics physics;
};

/// About as large as on published motors.
inline std::vector<PhysicsKind> KindsFor(const Rig& rig) {
  const double w = rig.k * rig.high_v / rig.ke * 0.8;
  const double i = 1.0 * rig.k * (rig.high_v - rig.low_v) / rig.ra;
  const double n = w * 30.0 / 3.14159 / rig.gear;
  std::vector<PhysicsKind> kinds = {
      {"ideal", {}},
      {"brush w", {.brush_s_ohm_per_rad = 0.2 * rig.ra / w}},
      {"brush V", {.brush_v = 0.4}},
      {"brush R", {.brush_ohm = 0.3 * rig.ra, .brush_a = 0.3 * i}},
      {"sag", {.sag_a = 0.5 * i, .sag_ohm = 0.2 * rig.ra}},
      {"zeros", {.n_zero_rpm = 0.01 * n, .ia_zero_a = 0.02 * i}},
      {"tacho", {.tachometer_ripple = 0.02}},
      {"fan", {.fan = 0.3 * rig.mc / w / w}},
      {"stribeck", {.stribeck_nm = 0.5 * rig.mc, .stribeck_rad_s = 0.1 * w}},
      {"ripple", {.ripple = 0.02}},
      {"warming", {.warming_per_s = 0.03 / 60.0}},
      {"cogging", {.cogging_nm = 0.3 * rig.mc}},
  };
  Physics all = {.brush_ohm = 0.15 * rig.ra,
                 .brush_a = 0.3 * i,
                 .brush_s_ohm_per_rad = 0.1 * rig.ra / w,
                 .sag_a = 0.6 * i,
                 .sag_ohm = 0.1 * rig.ra,
                 .fan = 0.15 * rig.mc / w / w,
                 .stribeck_nm = 0.25 * rig.mc,
                 .stribeck_rad_s = 0.1 * w,
                 .ripple = 0.01,
                 .cogging_nm = 0.15 * rig.mc,
                 .tachometer_ripple = 0.01};
  kinds.push_back({"all", all});
  return kinds;
}

}  // namespace faultlab::core
