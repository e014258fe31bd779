#include "hardware/run_forecast.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/plant/converters.h"
#include "core/plant/plant.h"
#include "core/plant/simulate_record.h"
#include "core/types/check.h"
#include "core/types/number_text.h"
#include "hardware/bench/value_bounds.h"
#include "hardware/rig_limits.h"

namespace faultlab::hardware {
namespace {

using core::Bench;
using core::BenchChannel;
using core::BenchProfile;

/// Analog outputs of boards that are sold write -10 to 10 V.
constexpr double kTerminalV = 10.0;
constexpr double kNoEnd = std::numeric_limits<double>::infinity();

std::string Text(double value) {
  return core::Format("%.4g", value);
}

/// The usual simulator as if it were noiseless.
BenchProfile Quiet(const Bench& bench) {
  BenchProfile profile = bench.profiles.front();
  profile.noise = {};
  profile.friction.noise_rms_nm = 0.0;
  return profile;
}

/// The same with an amplifier that no supply ends.
BenchProfile Endless(const Bench& bench) {
  constexpr double kNoSupplyV = 1e6;
  BenchProfile profile = Quiet(bench);
  profile.amplifier.output_max_v = kNoSupplyV;
  profile.amplifier.quadrants = core::Quadrants::kFour;
  return profile;
}

struct Reached {
  SignalSpan uc, ua, um, ia, n;
};

Reached Play(const Bench& bench, std::span<const double> uc_v, const core::PlantParameters& rig) {
  const BenchProfile profile = Endless(bench);
  core::Plant plant(rig, profile, 0);
  Reached reached;
  for (const double uc : uc_v) {
    plant.SetInput(uc);
    plant.Advance(profile.delta_s);
    const core::PlantOutputs out = plant.outputs();
    reached.uc.Include(uc);
    reached.ua.Include(out.ua_v);
    reached.um.Include(out.um_v);
    reached.ia.Include(out.ia_a);
    reached.n.Include(core::GearRpm(out.omega_rad_s, rig.gear_ratio));
    plant.Advance(bench.period_s - profile.delta_s);
  }
  return reached;
}

/// Where the supply ends the output: what the description says of the bench and of its simulator.
SignalSpan SupplyOf(const Bench& bench) {
  const core::OperatingRange& range = bench.nominal.range;
  const core::AmplifierModel& amplifier = bench.profiles.front().amplifier;
  const bool two = amplifier.quadrants == core::Quadrants::kTwo;
  return {std::max(range.output_min_v, two ? 0.0 : -amplifier.output_max_v),
          std::min(range.output_max_v, amplifier.output_max_v)};
}

SignalForecast Measured(const char* name,
                        const char* unit,
                        const BenchChannel& channel,
                        const SignalSpan& reached) {
  const core::ReadingRange inside = channel.Inside();
  return {name, unit, reached, {inside.min, inside.max}, "its converter reads", channel.exists};
}

std::vector<SignalForecast> SignalsOf(const Bench& bench, const Reached& reached) {
  const double a = (-kTerminalV - bench.uc.offset_v) / bench.uc.v_per_unit;
  const double b = (kTerminalV - bench.uc.offset_v) / bench.uc.v_per_unit;
  const core::BenchLimits& limits = bench.limits;
  std::vector<SignalForecast> signals;
  signals.push_back(
      {"uc", "V", reached.uc, {limits.uc_v_min, limits.uc_v_max}, "the bench takes", true});
  signals.push_back({"uc",
                     "V",
                     reached.uc,
                     {std::min(a, b), std::max(a, b)},
                     "its converter at +-10 V writes",
                     true});
  signals.push_back({"output", "V", reached.ua, SupplyOf(bench), "the supply gives", true});
  signals.push_back(Measured("um", "V", bench.um, reached.um));
  signals.push_back(Measured("ua", "V", bench.ua, reached.ua));
  signals.push_back(Measured("ia", "A", bench.ia, reached.ia));
  SignalForecast speed = Measured("n", "rpm", bench.n, reached.n);
  speed.bounded_by = "its range is";
  if (bench.n.min <= -kRpmMax) speed.may.min = -kNoEnd;
  if (bench.n.max >= kRpmMax) speed.may.max = kNoEnd;
  signals.push_back(speed);
  return signals;
}

std::string Sentence(const SignalForecast& signal) {
  return signal.name + " goes from " + Text(signal.reaches.min) + " to " +
         Text(signal.reaches.max) + " " + signal.unit + ", " + signal.bounded_by + " " +
         Text(signal.may.min) + " to " + Text(signal.may.max) + " " + signal.unit;
}

/// The seed of a run chooses where these begin.
bool BeginsAnywhere(const core::ExcitationSpec& excitation) {
  return std::holds_alternative<core::PrbsSpec>(excitation) ||
         std::holds_alternative<core::MultisineSpec>(excitation);
}

/// The steepest step of the input, the first from 0.
double SteepestStep(const Bench& bench, std::span<const double> uc_v) {
  double steepest = 0.0;
  if (BeginsAnywhere(bench.excitation)) {
    const auto [low, high] = std::minmax_element(uc_v.begin(), uc_v.end());
    steepest = std::abs(*low) > std::abs(*high) ? *low : *high;
  }
  double before = 0.0;
  for (const double uc : uc_v) {
    if (std::abs(uc - before) > std::abs(steepest)) steepest = uc - before;
    before = uc;
  }
  return steepest;
}

std::optional<RunProblem> TooSteep(const Bench& bench, std::span<const double> uc_v) {
  const double step_v = SteepestStep(bench, uc_v);
  const double may_v = bench.limits.slew_v_per_s * bench.period_s;
  constexpr double kMayRounded = 1.0 + 1e-9;
  if (std::abs(step_v) <= may_v * kMayRounded) return std::nullopt;
  return RunProblem{"slew",
                    "uc steps by " + Text(step_v) + " V within a period of " +
                        Text(1e3 * bench.period_s) + " ms, limits.slew_v_per_s = " +
                        Text(bench.limits.slew_v_per_s) + " allows " + Text(may_v) + " V"};
}

/// The first interlock that the run would meet.
std::optional<RunProblem> TripOf(const Bench& bench,
                                 std::span<const double> uc_v,
                                 const core::PlantParameters& rig) {
  Interlocks interlocks(bench.limits);
  for (const core::Sample& sample :
       core::SimulateRecord(Quiet(bench), rig, uc_v, {}, 0, bench.period_s)) {
    if (const auto trip = interlocks.Check(sample, bench.period_s)) {
      return RunProblem{trip->name,
                        "the interlock " + trip->name + " ends the run after " + Text(trip->t_s) +
                            " s: " + trip->text};
    }
  }
  return std::nullopt;
}

}  // namespace

RunForecast ForecastRun(const Bench& bench,
                        std::span<const double> uc_v,
                        const std::optional<core::Fault>& fault) {
  LAB_CHECK(!uc_v.empty() && !bench.profiles.empty());
  core::PlantParameters rig = bench.nominal;
  if (fault) rig.Set(fault->component, fault->value);
  RunForecast forecast;
  forecast.signals = SignalsOf(bench, Play(bench, uc_v, rig));
  for (const SignalForecast& signal : forecast.signals) {
    if (signal.fits()) continue;
    forecast.problems.push_back({signal.name + " " + signal.bounded_by, Sentence(signal)});
  }
  if (const auto steep = TooSteep(bench, uc_v)) forecast.problems.push_back(*steep);
  if (const auto trip = TripOf(bench, uc_v, rig)) forecast.problems.push_back(*trip);
  return forecast;
}

}  // namespace faultlab::hardware
