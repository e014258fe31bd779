#include "hardware/bench/bench_reader.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/signals/excitation_text.h"
#include "core/structures/structures.h"
#include "core/types/number_text.h"
#include "hardware/bench/channel_reader.h"
#include "hardware/bench/component_reader.h"
#include "hardware/bench/publication_reader.h"
#include "hardware/bench/value_bounds.h"
#include "hardware/config/toml_table.h"

namespace faultlab::hardware {
namespace {

using core::Bench;
using core::BenchProfile;

constexpr double kPeriodMinS = 1e-3;
constexpr double kPeriodMaxS = 0.1;
/// Length of the run for which the excitation has to make sense.
constexpr double kUsualRunS = 20.0;

constexpr std::size_t kTitleBytesMax = 100;

std::string Digits(double value) {
  return core::Format("%.3g", value);
}

bool IsName(const std::string& text) {
  return !text.empty() && text.size() <= 40 && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

/// See Bench::id.
std::string IdOf(const Bench& bench, const std::string& contents) {
  constexpr std::size_t kBytes = 6;
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(
      hash.data(), reinterpret_cast<const unsigned char*>(contents.data()), contents.size());
  std::array<char, 2 * kBytes + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), hash.data(), kBytes);
  return bench.name + "-" + hex.data();
}

/// A PRBS, whose usual clock of 10 ms is too fast for slow benches.
std::string UsualExcitation(double period_s) {
  if (period_s <= core::PrbsSpec{}.clock_s) return "prbs";
  return "prbs:clock=" + core::Shortest(period_s);
}

void ReadHead(TomlTable& head, Bench& bench) {
  head.Text("name", bench.name);
  if (!IsName(bench.name)) head.Refuse("name", "must be of a-z, 0-9 and -, at most 40");
  head.Text("title", bench.title);
  if (bench.title.empty()) bench.title = bench.name;
  if (bench.title.size() > kTitleBytesMax) {
    head.Refuse("title", "must be at most " + std::to_string(kTitleBytesMax) + " bytes");
  }
  bench.rig_class = bench.name;
  head.Text("rig_class", bench.rig_class);
  if (!IsName(bench.rig_class)) head.Refuse("rig_class", "must be of a-z, 0-9 and -, at most 40");
  std::vector<std::string> names;
  for (const core::Structure* each : core::Structures()) names.emplace_back(each->name);
  const int structure = head.Choice("structure", -1, names);
  if (structure < 0) head.Refuse("structure", "is missing");
  bench.structure = core::Structures()[static_cast<std::size_t>(structure)];
  head.Number("period_s", bench.period_s, kPeriodMinS, kPeriodMaxS);
  bench.delta_s = 0.5 * bench.period_s;
  head.Number("delta_s", bench.delta_s, 0.0, kPeriodMaxS);
  if (!(bench.delta_s > 0.0 && bench.delta_s < bench.period_s)) {
    head.Refuse("delta_s", "must lie inside the period");
  }
  bench.excitation_text = UsualExcitation(bench.period_s);
  head.Text("excitation", bench.excitation_text);
  auto excitation = core::ParseExcitation(bench.excitation_text, 1);
  if (!excitation) head.Refuse("excitation", "is refused: " + excitation.error().message);
  bench.excitation = std::move(excitation).value();
  const auto samples = core::Generate(bench.excitation, kUsualRunS, bench.period_s);
  if (!samples) {
    head.Refuse("excitation",
                "cannot be played for 20 s at this period: " + samples.error().field + ": " +
                    samples.error().message);
  }
  head.Flag("fits_follow_noise", bench.fits_follow_noise);
  head.Number("input_min_v", bench.input_min_v, -100.0, 100.0);
  head.Number("input_max_v", bench.input_max_v, -100.0, 100.0);
  if (!(bench.input_min_v < bench.input_max_v)) {
    head.Refuse("input_max_v", "must be above input_min_v");
  }
}

/// Data sheets give J in g cm^2, Ke in V per 1000 rpm and La in mH: a wrong unit shows in the time
/// constants, or in Ke and KT, which are one number.
void CheckUnits(const TomlTable& plant, const core::PlantParameters& p) {
  const auto outside = [](double value, double min, double max) {
    return !(value >= min && value <= max);
  };
  const bool source = p.structure->drives_current();
  const double resistance_ohm = p.ra_ohm + (source ? 0.0 : p.series_ohm);
  const double ratio = p.kt_nm_per_a / p.ke_v_per_rad_s;
  if (outside(ratio, 1.0 / 3.0, 3.0)) {
    plant.Refuse(
        "KT", "is " + Digits(ratio) + " of Ke, but Nm/A and V/(rad/s) are the same number: units?");
  }
  const double mechanical_s =
      p.j_kg_m2 * resistance_ohm /
      (p.b_nm_per_rad_s * resistance_ohm + p.ke_v_per_rad_s * p.kt_nm_per_a);
  if (outside(mechanical_s, 1e-5, 1e4)) {
    plant.Refuse("J",
                 "gives the motor a time constant of " + Digits(mechanical_s) +
                     " s with Ra, Ke, KT and B, 1e-05 to 1e+04 may be: units?");
  }
  const double electrical_s = p.la_henry / resistance_ohm;
  if (outside(electrical_s, 1e-8, 10.0)) {
    plant.Refuse("La",
                 "gives the winding a time constant of " + Digits(electrical_s) +
                     " s with Ra, 1e-08 to 10 may be: units?");
  }
}

void ReadPlant(TomlTable& plant, Bench& bench) {
  bench.nominal.structure = bench.structure;
  for (int i = 0; i < bench.structure->parameter_count(); ++i) {
    const core::ParameterInfo& info = bench.structure->parameters[static_cast<std::size_t>(i)];
    if (i == core::kSeries && bench.structure->drives_current()) {
      bench.nominal.Set(i, bench.structure->source_ohm);
      continue;
    }
    double value = -1.0;
    // A bench may stand without a series resistor.
    const double min = i == core::kSeries ? 0.0 : kValueMin;
    plant.Number(std::string(info.symbol), value, min, kValueMax);
    if (value < min) {
      if (i == core::kSeries) {
        value = 0.0;
      } else {
        plant.Refuse(std::string(info.symbol),
                     "is missing: " + std::string(info.meaning) + ", " + std::string(info.unit));
      }
    }
    bench.nominal.Set(i, value);
  }
  plant.Number("gear_ratio", bench.nominal.gear_ratio, 1e-3, 1e3);
  CheckUnits(plant, bench.nominal);
}

/// Speed (rad/s) without load or dry friction at this voltage of the output. A motor that is driven
/// by its voltage turns as fast as Ke says.
double FreeSpeedOf(const core::PlantParameters& p, double output_v) {
  if (!p.structure->drives_current()) return output_v / p.ke_v_per_rad_s;
  return p.kt_nm_per_a * output_v / p.series_ohm / p.b_nm_per_rad_s;
}

/// How large the signals get follows from the data sheet, unless the file says it. Returns the
/// torque of the motor at rest under the largest input.
double ReadOperatingRange(TomlTable& root, Bench& bench) {
  core::PlantParameters& p = bench.nominal;
  core::OperatingRange& range = p.range;
  TomlTable& head = root.Sub("bench");
  // The output of a rig at rest is 0 V.
  constexpr double kOutputLeastV = 0.1;
  constexpr double kOutputMaxV = 1e4;
  for (const char* key : {"output_min_v", "output_max_v"}) {
    if (p.structure->drives_current() && head.Has(key)) {
      head.Refuse(key,
                  "is not known to the model of a current-driver: give a simulator its "
                  "output_max_v");
    }
  }
  if (head.Has("output_min_v")) {
    range.output_min_v = 0.0;
    head.Number("output_min_v", range.output_min_v, -kOutputMaxV, 0.0);
  }
  if (head.Has("output_max_v")) {
    range.output_max_v = 0.0;
    head.Number("output_max_v", range.output_max_v, kOutputLeastV, kOutputMaxV);
  }
  // Twice what a motor at rest takes, and twice what it reaches without load.
  constexpr double kRoom = 2.0;
  range.input_v = std::max(std::abs(bench.input_min_v), std::abs(bench.input_max_v));
  const double limit_v =
      std::min(std::max(std::abs(range.output_min_v), std::abs(range.output_max_v)),
               p.gain() * range.input_v);
  const double resistance_ohm = p.ra_ohm + p.series_ohm;
  range.current_a = kRoom * limit_v / resistance_ohm;
  range.speed_rad_s = kRoom * FreeSpeedOf(p, limit_v);
  range.creep_rad_s = 0.0;
  TomlTable& table = root.Sub("operating_range");
  table.Number("input_v", range.input_v, 1e-3, 1e4);
  table.Number("current_a", range.current_a, 1e-6, 1e6);
  table.Number("speed_rad_s", range.speed_rad_s, 1e-3, 1e6);
  table.Number("creep_rad_s", range.creep_rad_s, 0.0, 1e6);
  return p.kt_nm_per_a * limit_v / resistance_ohm;
}

/// Numbers that a laboratory states of its motor and amplifier. Without the table a rig of this
/// class can only be simulated.
void ReadLimits(TomlTable& root, Bench& bench) {
  core::BenchLimits& limits = bench.limits;
  limits.uc_v_min = bench.input_min_v;
  limits.uc_v_max = bench.input_max_v;
  TomlTable& table = root.Sub("limits");
  bench.limits_stated = root.Has("limits");
  table.Number("uc_min_v", limits.uc_v_min, bench.input_min_v, bench.input_max_v);
  table.Number("uc_max_v", limits.uc_v_max, limits.uc_v_min, bench.input_max_v);
  if (!bench.limits_stated) return;
  const auto number = [&table](const char* key, double& value, double min, double max) {
    value = -1.0;
    table.Number(key, value, min, max);
    if (value < 0.0) table.Refuse(key, "is missing");
  };
  number("slew_v_per_s", limits.slew_v_per_s, 1e-3, 1e9);
  number("voltage_max_v", limits.voltage_v_max, 1e-3, 1e4);
  number("current_continuous_a", limits.current_continuous_a, 1e-6, 1e4);
  number("current_peak_a", limits.current_peak_a, 1e-6, 1e4);
  // An interlock that its channel cannot reach never acts.
  const double reach_a = bench.ia.min < 0.0 ? std::min(-bench.ia.min, bench.ia.max) : bench.ia.max;
  if (bench.ia.exists && limits.current_peak_a >= reach_a) {
    table.Refuse("current_peak_a", "must lie inside the range of [channel.ia]");
  }
  if (limits.current_continuous_a > limits.current_peak_a) {
    table.Refuse("current_continuous_a", "must not be above current_peak_a");
  }
  number("thermal_tau_s", limits.thermal_tau_s, 1e-2, 1e5);
  number("stall_current_a", limits.stall_current_a, 1e-6, 1e4);
  number("stall_speed_rpm", limits.stall_speed_rpm, 1e-3, 1e6);
  number("stall_s", limits.stall_s, 0.01, 1e3);
  table.Number("relay_rest_s", limits.relay_rest_s, 0.01, 60.0);
  table.Number("relay_life", limits.relay_life, 1.0, 1e10);
}

constexpr double kFrictionMinNm = 1e-9;

/// @param stall_nm  torque of the motor at rest under the largest input
/// @param sees_lag  the amplifier's lag is not small beside the sample period
void ReadNorm(TomlTable& table, double stall_nm, bool sees_lag, core::BenchNorm& norm) {
  const auto share = [&table](const char* key, double& value) {
    table.Number(key, value, 1e-4, 1.0);
  };
  share("gain", norm.gain);
  share("series", norm.series);
  share("Ra", norm.ra);
  share("J", norm.j);
  share("B", norm.b);
  share("Ke", norm.ke);
  norm.la = 0.10;
  table.Number("La", norm.la, 0.0, 1.0);
  norm.lag = sees_lag ? 0.10 : 0.0;
  table.Number("lag", norm.lag, 0.0, 1.0);
  // Friction that is not stated is a fiftieth of what the motor has at rest, and as uncertain.
  constexpr double kFrictionShare = 0.02;
  constexpr double kFrictionNoiseShare = 0.06;
  norm.mc_nm = kFrictionShare * stall_nm;
  table.Number("mc_nm", norm.mc_nm, 0.0, 1e3);
  norm.mc_sigma_nm = std::max(table.Has("mc_nm") ? 0.5 * norm.mc_nm : norm.mc_nm, kFrictionMinNm);
  norm.friction_noise_nm = std::max(kFrictionNoiseShare * norm.mc_nm, kFrictionMinNm);
  table.Number("mc_sigma_nm", norm.mc_sigma_nm, 1e-9, 1e3);
  table.Number("friction_noise_nm", norm.friction_noise_nm, 1e-9, 1e3);
  table.Number("warming", norm.warming, 0.0, 1.0);
  table.Flag("missing_physics", norm.missing_physics);
  table.Number("friction_tau_s", norm.friction_tau_s, 1e-3, 1e3);
}

/// The amplifier of a simulator that says nothing of its own.
core::AmplifierModel AmplifierOf(const Bench& bench) {
  core::AmplifierModel amplifier;
  const core::OperatingRange& supply = bench.nominal.range;
  if (std::isfinite(supply.output_max_v)) amplifier.output_max_v = supply.output_max_v;
  const bool below_0 =
      std::isfinite(supply.output_min_v) ? supply.output_min_v < 0.0 : bench.input_min_v < 0.0;
  amplifier.quadrants = below_0 ? core::Quadrants::kFour : core::Quadrants::kTwo;
  return amplifier;
}

void ReadSimulator(TomlTable& table, Bench& bench) {
  BenchProfile profile;
  profile.amplifier = AmplifierOf(bench);
  profile.delta_s = bench.delta_s;
  profile.noise = {bench.um.noise, bench.ua.noise, bench.ia.noise, bench.n.noise};
  table.Text("name", profile.name);
  if (!IsName(profile.name) || bench.FindProfile(profile.name) != nullptr) {
    table.Refuse("name", "must be a name of a-z, 0-9 and -, once in this file");
  }
  table.Number("delta_s", profile.delta_s, 0.0, bench.period_s);
  if (!(profile.delta_s > 0.0 && profile.delta_s < bench.period_s)) {
    table.Refuse("delta_s", "must lie inside the period");
  }
  core::FrictionModel& friction = profile.friction;
  table.Number("mc_nm", friction.mc_nm, 0.0, 1e3);
  friction.ms_nm = friction.mc_nm;
  table.Number("ms_nm", friction.ms_nm, friction.mc_nm, 1e3);
  friction.stribeck_shape =
      table.Choice("friction_shape", friction.stribeck_shape, {"none", "tustin", "gauss"});
  table.Number("stribeck_speed_rad_s", friction.stribeck_speed_rad_s, 1e-6, 1e6);
  table.Number("friction_noise_nm", friction.noise_rms_nm, 0.0, 1e3);
  table.Number("friction_tau_s", friction.noise_tau_s, 1e-3, 1e3);
  table.Number("um_noise_v", profile.noise.um_v, 0.0, 1e3);
  table.Number("ua_noise_v", profile.noise.ua_v, 0.0, 1e3);
  table.Number("ia_noise_a", profile.noise.ia_a, 0.0, 1e3);
  table.Number("n_noise_rpm", profile.noise.n_rpm, 0.0, 1e5);
  table.Number("output_max_v", profile.amplifier.output_max_v, 0.1, 1e3);
  const int quadrants = profile.amplifier.quadrants == core::Quadrants::kFour ? 1 : 0;
  profile.amplifier.quadrants = table.Choice("quadrants", quadrants, {"two", "four"}) == 1
                                    ? core::Quadrants::kFour
                                    : core::Quadrants::kTwo;
  bench.profiles.push_back(std::move(profile));
}

void Read(TomlTable& root, Bench& bench) {
  ReadHead(root.Sub("bench"), bench);
  ReadPlant(root.Sub("plant"), bench);
  ReadComponents(root, bench);
  ReadChannels(root, bench);
  ReadPublication(root, bench);
  ReadLimits(root, bench);
  const double stall_nm = ReadOperatingRange(root, bench);
  constexpr double kLagSeenPeriods = 0.02;
  const bool sees_lag = bench.nominal.response().lag_s > kLagSeenPeriods * bench.period_s;
  bench.norm.missing_physics = bench.fits_follow_noise;
  ReadNorm(root.Sub("norm"), stall_nm, sees_lag, bench.norm);
  constexpr double kHeld = 1e-6;
  if (bench.structure->drives_current()) bench.norm.series = kHeld;
  const auto input = core::Generate(bench.excitation, kUsualRunS, bench.period_s);
  double peak_v = 0.0;
  for (const double uc_v : input.value()) peak_v = std::max(peak_v, std::abs(uc_v));
  bench.usual_speed_rad_s = FreeSpeedOf(bench.nominal, bench.nominal.gain() * peak_v);
  for (TomlTable* table : root.Subs("simulator")) ReadSimulator(*table, bench);
  if (bench.profiles.empty()) {
    BenchProfile usual;
    usual.name = "bench";
    usual.delta_s = bench.delta_s;
    usual.amplifier = AmplifierOf(bench);
    usual.friction = {.mc_nm = bench.norm.mc_nm,
                      .ms_nm = bench.norm.mc_nm,
                      .noise_rms_nm = bench.norm.friction_noise_nm,
                      .noise_tau_s = bench.norm.friction_tau_s};
    usual.noise = {bench.um.noise, bench.ua.noise, bench.ia.noise, bench.n.noise};
    bench.profiles.push_back(std::move(usual));
  }
  for (BenchProfile& profile : bench.profiles) {
    profile.converters.has_um = bench.um.exists;
    profile.converters.has_ua = bench.ua.exists;
    profile.converters.has_ia = bench.ia.exists;
    profile.converters.has_n = bench.n.exists;
    profile.converters.range_v =
        bench.um.exists ? std::max(std::abs(bench.um.min), bench.um.max) : 10.0;
    if (bench.ia.exists) {
      profile.converters.ia_v_per_a =
          profile.converters.range_v / std::max(std::abs(bench.ia.min), bench.ia.max);
    }
    profile.converters.tachometer = bench.n.tachometer;
    profile.converters.counts = bench.n.counted;
    profile.converters.pulses_per_revolution = bench.pulses_per_revolution;
  }
}

}  // namespace

core::Result<Bench> ReadBench(std::string_view text, std::string_view name) {
  Bench bench;
  std::string contents;
  TRY_DONE(ReadToml(text, name, [&](TomlTable& root) {
    Read(root, bench);
    contents = root.Contents();
  }));
  bench.text = text;
  bench.id = IdOf(bench, contents);
  return bench;
}

}  // namespace faultlab::hardware
