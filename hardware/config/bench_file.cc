#include "hardware/config/bench_file.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/types/check.h"
#include "hardware/bench/benches.h"
#include "hardware/config/toml_table.h"
#include "hardware/daq/guarded_daq.h"
#include "hardware/device/device_machine.h"
#include "hardware/refusal.h"

namespace faultlab::hardware {
namespace {

void ReadScale(TomlTable& section,
               const std::string& name,
               const std::string& unit,
               ChannelScale& s) {
  constexpr double kGainMax = 1e4;
  const std::string key = name + "_v_per_" + unit;
  double gain = s.v_per_unit;
  section.Number(key, gain, -kGainMax, kGainMax);
  if (gain == 0.0) section.Refuse(key, "must not be 0");
  s.v_per_unit = gain;
  section.Number(name + "_offset_v", s.offset_v, -10.0, 10.0);
}

Nanoseconds Milliseconds(double value) {
  return Nanoseconds(std::llround(value * 1e6));
}

void ReadRelays(TomlTable& relays, BenchFile& file) {
  RelayWiring& wiring = file.config.wiring;
  if (file.driver == BenchFile::Driver::kDevice) {
    if (relays.Has("inverted")) {
      relays.Refuse("inverted", "belongs into the device: its lines are told as connected or not");
    }
    wiring.inverted = false;
  }
  relays.Flag("inverted", wiring.inverted);
  for (const core::Component component : wiring.boards) {
    const std::string symbol(core::Name(component));
    if (relays.Has(symbol)) {
      relays.Refuse(symbol,
                    "belongs into the bench's description now: `lines` of its [[component]]");
    }
  }
  double gap_ms = 3.0;
  double settle_ms = 3.0;
  double rest_ms = 1e3 * file.config.limits.relay_rest_s;
  relays.Number("gap_ms", gap_ms, 0.5, 1000.0);
  relays.Number("settle_ms", settle_ms, 0.5, 1000.0);
  relays.Number("rest_ms", rest_ms, 10.0, 60000.0);
  file.config.timing = {.gap = Milliseconds(gap_ms), .settle = Milliseconds(settle_ms)};
  file.config.limits.relay_rest_s = rest_ms * 1e-3;
}

/// Relays have settled before the sample is read. Refuses the key that the file has.
void CheckRelayTime(TomlTable& root, const BenchFile& file, double delta_ms) {
  const RelayTiming& timing = file.config.timing;
  if (file.config.wiring.boards.empty() || timing.gap + timing.settle < Milliseconds(delta_ms)) {
    return;
  }
  const auto milliseconds = [](Nanoseconds span) {
    return Number(std::chrono::duration<double, std::milli>(span).count());
  };
  TomlTable& loop = root.Sub("loop");
  TomlTable& relays = root.Sub("relays");
  const std::string what = "gap_ms " + milliseconds(timing.gap) + " + settle_ms " +
                           milliseconds(timing.settle) + " must be below delta_ms " +
                           Number(delta_ms) + ": the sample would be read while relays move";
  if (loop.Has("delta_ms")) loop.Refuse("delta_ms", "is too short: relays." + what);
  const std::string key = relays.Has("gap_ms") || !relays.Has("settle_ms") ? "gap_ms" : "settle_ms";
  relays.Refuse(key,
                std::string(relays.Has(key) ? "is too long: " : "is missing and then 3: ") + what +
                    " (delta_s of the bench's description)");
}

void ReadLimits(TomlTable& limits, RigLimits& to) {
  limits.Number("uc_min_v", to.uc_v_min, -100.0, 0.0);
  limits.Number("uc_max_v", to.uc_v_max, 0.1, 100.0);
  limits.Number("slew_v_per_s", to.slew_v_per_s, 1.0, 1e6);
  limits.Number("voltage_max_v", to.voltage_v_max, 1.0, 60.0);
  limits.Number("current_continuous_a", to.current_continuous_a, 0.01, 20.0);
  limits.Number("current_peak_a", to.current_peak_a, 0.01, 100.0);
  limits.Number("thermal_tau_s", to.thermal_tau_s, 0.1, 1e4);
  limits.Number("stall_current_a", to.stall_current_a, 0.01, 100.0);
  limits.Number("stall_speed_rpm", to.stall_speed_rpm, 0.1, 1e4);
  limits.Number("stall_s", to.stall_s, 0.02, 60.0);
}

/// Volts at the terminal at which a channel shows this value, of either sign.
double TerminalReach(const ChannelScale& scale, double value) {
  return std::max(std::abs(scale.ToTerminal(value)), std::abs(scale.ToTerminal(-value)));
}

/// An interlock that its channel cannot reach never acts: as for a description, of this rig's own
/// limits and scaling.
void CheckReach(TomlTable& root, const BenchFile& file) {
  constexpr double kConverterV = 10.0;  // of the widest range that boards are sold with
  const RigLimits& limits = file.config.limits;
  const ChannelScaling& scaling = file.config.scaling;
  const RigDescription& rig = file.config.description;
  TomlTable& table = root.Sub("limits");
  const auto refuse = [&](const char* key, double value, const char* what) {
    table.Refuse(key,
                 "is " + Number(value) + ", which " + what + " cannot read: it would never act");
  };
  const bool um = rig.has_um && TerminalReach(scaling.um, limits.voltage_v_max) >= kConverterV;
  const bool ua = rig.has_ua && TerminalReach(scaling.ua, limits.voltage_v_max) >= kConverterV;
  if (um || ua) refuse("voltage_max_v", limits.voltage_v_max, um ? "um" : "ua");
  if (rig.has_ia && TerminalReach(scaling.ia, limits.current_peak_a) >= kConverterV) {
    refuse("current_peak_a", limits.current_peak_a, "ia");
  }
  if (rig.has_ia && TerminalReach(scaling.ia, limits.stall_current_a) >= kConverterV) {
    refuse("stall_current_a", limits.stall_current_a, "ia");
  }
  if (limits.current_continuous_a > limits.current_peak_a) {
    table.Refuse("current_continuous_a", "must not be above current_peak_a");
  }
}

void ReadDriver(TomlTable& root, BenchFile& file) {
  file.driver = static_cast<BenchFile::Driver>(
      root.Choice("driver", 0, {"simulated", "nidaqmx", "comedi", "device"}));
  TomlTable& simulated = root.Sub("simulated");
  std::vector<std::string> profiles;
  for (const core::BenchProfile& each : file.config.description.bench->profiles) {
    profiles.push_back(each.name);
  }
  file.simulated.profile =
      profiles[static_cast<std::size_t>(simulated.Choice("profile", 0, profiles))];
  simulated.Number("speed", file.simulated.speed, 0.0, 1e6);

  TomlTable& ni = root.Sub("nidaqmx");
  ni.Text("library", file.nidaqmx.library);
  ni.Text("drive", file.nidaqmx.drive);
  ni.Text("um", file.nidaqmx.um);
  ni.Text("ua", file.nidaqmx.ua);
  ni.Text("ia", file.nidaqmx.ia);
  ni.Word("terminal", file.nidaqmx.terminal, {"rse", "nrse", "diff"});
  ni.Text("relays", file.nidaqmx.relays);
  ni.Text("counter", file.nidaqmx.counter);
  file.nidaqmx.quadrature = ni.Choice("counts", 0, {"edges", "quadrature"}) == 1;
  ni.Text("watchdog", file.nidaqmx.watchdog);
  double watchdog_ms = 200.0;
  ni.Number("watchdog_ms", watchdog_ms, 20.0, 10'000.0);
  file.nidaqmx.watchdog_s = watchdog_ms * 1e-3;

  TomlTable& comedi = root.Sub("comedi");
  comedi.Text("library", file.comedi.library);
  comedi.Text("device", file.comedi.device);
  const auto number = [&comedi](const char* key, int& value, int min) {
    comedi.Integer(key, value, min, 255);
  };
  number("analog_in", file.comedi.analog_in, 0);
  number("analog_out", file.comedi.analog_out, 0);
  comedi.OneOrMore("digital", file.comedi.digital, 0, 255);
  number("counter", file.comedi.counter, -1);
  number("drive", file.comedi.drive, 0);
  number("um", file.comedi.um, 0);
  number("ua", file.comedi.ua, -1);
  number("ia", file.comedi.ia, -1);
  number("counter_channel", file.comedi.counter_channel, 0);
  file.comedi.counts =
      static_cast<CountDirection>(comedi.Choice("counts", 0, {"up", "down", "both"}));
  number("relay_base", file.comedi.relay_base, 0);
  number("range", file.comedi.range, 0);
  comedi.Word("reference", file.comedi.reference, {"ground", "common", "diff"});
  file.comedi.may_scan = comedi.Choice("conversions", 0, {"auto", "read"}) == 0;

  TomlTable& device = root.Sub("device");
  device.Text("port", file.device.port);
  device.Integer("baud", file.device.baud, 1200, 4'000'000);
  if (file.driver == BenchFile::Driver::kDevice || device.Has("port")) {
    if (const std::string problem = PortProblem(file.device.port); !problem.empty()) {
      device.Refuse("port", problem);
    }
  }
}

/// A motor that reverses needs a counter that knows the sense: others give the speed without sign.
void CheckDirection(TomlTable& root, const BenchFile& file) {
  const bool comedi = file.driver == BenchFile::Driver::kComedi;
  if (!file.config.description.has_n || file.config.limits.uc_v_min >= 0.0) return;
  if (comedi && file.comedi.counts == CountDirection::kBoth) return;
  if (!comedi && file.nidaqmx.quadrature) return;
  const std::string why = "knows no direction, but uc may be " +
                          Number(file.config.limits.uc_v_min) +
                          " V and the motor then turns backwards: ";
  if (comedi) {
    root.Sub("comedi").Refuse(
        "counts",
        "is \"" + std::string(file.comedi.counts == CountDirection::kUp ? "up" : "down") +
            "\": such a counter " + why +
            "use one that decodes both channels of the encoder and write counts = \"both\", or "
            "write counter = -1, or limits.uc_min_v = 0");
  }
  root.Sub("nidaqmx").Refuse(
      "counter",
      "counts edges: it " + why +
          "wire both channels of the encoder and write counts = \"quadrature\", or write counter "
          "= \"\", or limits.uc_min_v = 0");
}

void Read(TomlTable& root, const std::string& asked, BenchFile& file) {
  RigDescription& description = file.config.description;
  root.Text("id", description.id);
  root.Text("calibration", file.calibration);
  std::string bench;
  root.Text("bench", bench);
  const core::Result<const core::Bench*> known = LoadBench(asked.empty() ? bench : asked);
  if (!known) root.Refuse("bench", "is refused: " + known.error().message);
  const std::string id = description.id;
  file.config = ConfigOf(*known.value());
  description.id = id;
  root.Text("class", description.rig_class);
  file.simulated.bench = known.value();
  ReadDriver(root, file);
  const bool simulated = file.driver == BenchFile::Driver::kSimulated;
  if (!simulated && !known.value()->limits_stated) {
    root.Refuse("bench", "describes no [limits]: say there what the motor stands");
  }
  description.kind = simulated ? RigKind::kSimulated : RigKind::kBench;
  // Else it would be given to who has asked for a bench, or a session to who practises.
  if (simulated && !root.Has("class")) description.rig_class += kFarSimulators;

  TomlTable& scaling = root.Sub("scaling");
  ReadScale(scaling, "uc", "v", file.config.scaling.uc);
  ReadScale(scaling, "um", "v", file.config.scaling.um);
  ReadScale(scaling, "ua", "v", file.config.scaling.ua);
  ReadScale(scaling, "ia", "a", file.config.scaling.ia);

  TomlTable& encoder = root.Sub("encoder");
  encoder.Integer("pulses_per_revolution", file.config.scaling.pulses_per_revolution, 1, 100000);
  encoder.Number("gear_ratio", file.config.scaling.gear_ratio, 0.01, 1000.0);
  const bool comedi = file.driver == BenchFile::Driver::kComedi;
  const bool quadrature = file.driver == BenchFile::Driver::kNiDaqmx && file.nidaqmx.quadrature;
  file.config.scaling.speed = static_cast<SpeedMethod>(
      encoder.Choice("method", comedi || quadrature ? 1 : 0, {"frequency", "count"}));
  if (comedi && file.config.scaling.speed == SpeedMethod::kPulseFrequency) {
    encoder.Refuse("method", "must be \"count\": Comedi has no frequency");
  }
  if (quadrature && file.config.scaling.speed == SpeedMethod::kPulseFrequency) {
    encoder.Refuse("method", "must be \"count\": nidaqmx.counts is \"quadrature\"");
  }
  constexpr int kCountsOfPulse = 4;  // each edge of both channels
  if (quadrature) file.config.scaling.pulses_per_revolution *= kCountsOfPulse;

  ReadRelays(root.Sub("relays"), file);
  ReadLimits(root.Sub("limits"), file.config.limits);

  TomlTable& amplifier = root.Sub("amplifier");
  if (amplifier.Choice("mode", 0, {"voltage", "current"}) == 1) {
    amplifier.Refuse(
        "mode",
        "is \"current\", which cannot be diagnosed: the estimators and the rig's check "
        "are of an amplifier that gives a voltage, and at a constant current a motor "
        "without load runs up until over_voltage trips: wire the amplifier for voltage "
        "and write mode = \"voltage\"");
  }
  int quadrants = 2;
  amplifier.Integer("quadrants", quadrants, 2, 4);
  if (quadrants == 3) amplifier.Refuse("quadrants", "must be 2 or 4");
  description.amplifier_quadrants = quadrants == 4 ? core::Quadrants::kFour : core::Quadrants::kTwo;
  if (quadrants == 2 && file.config.limits.uc_v_min < 0.0) {
    const bool of_this_rig = root.Sub("limits").Has("uc_min_v");
    amplifier.Refuse("quadrants",
                     std::string(amplifier.Has("quadrants") ? "is 2" : "is missing and then 2") +
                         ", but uc may be " + Number(file.config.limits.uc_v_min) + " V by " +
                         (of_this_rig ? "limits.uc_min_v"
                                      : "the description of the bench " + known.value()->name) +
                         ": write quadrants = 4, or limits.uc_min_v = 0");
  }

  TomlTable& loop = root.Sub("loop");
  double delta_ms = 1e3 * description.delta_s;
  loop.Number("delta_ms", delta_ms, 0.1, 1000.0);
  description.delta_s = delta_ms * 1e-3;
  const double period_ms = 1e3 * description.bench->period_s;
  if (!simulated && delta_ms >= period_ms) {
    loop.Refuse("delta_ms", "must lie inside the period of " + Number(period_ms) + " ms");
  }
  loop.Integer("fifo_priority", file.fifo_priority, 0, 99);
  loop.Integer("late_ticks_max", file.late_ticks_max, 1, 1000);
  double driver_timeout_ms = 250.0;
  loop.Number("driver_timeout_ms", driver_timeout_ms, 20.0, 10'000.0);
  file.driver_patience = Milliseconds(driver_timeout_ms);
  if (!simulated) CheckRelayTime(root, file, delta_ms);

  TomlTable& link = root.Sub("link");
  link.Number("ride_through_s", file.ride_through_s, 0.0, 120.0);

  // What a device lacks, it says itself.
  const bool board = !simulated && file.driver != BenchFile::Driver::kDevice;
  const auto wired = [&](bool described, bool on_comedi, const std::string& ni_channel) {
    return described && (!board || (comedi ? on_comedi : !ni_channel.empty()));
  };
  description.has_ua = wired(description.has_ua, file.comedi.ua >= 0, file.nidaqmx.ua);
  description.has_ia = wired(description.has_ia, file.comedi.ia >= 0, file.nidaqmx.ia);
  description.has_n = wired(description.has_n, file.comedi.counter >= 0, file.nidaqmx.counter);
  if (!simulated) CheckDirection(root, file);
  if (!simulated) CheckReach(root, file);
  file.simulated.rig_class = description.rig_class;
  file.simulated.amplifier_quadrants = description.amplifier_quadrants;
  file.simulated.gated_speed = file.config.scaling.speed == SpeedMethod::kGatedCount;
}

}  // namespace

core::Result<BenchFile> ParseBenchFile(std::string_view text,
                                       std::string_view name,
                                       const std::string& bench) {
  BenchFile file;
  TRY_DONE(ReadToml(text, name, [&](TomlTable& root) { Read(root, bench, file); }));
  return file;
}

core::Result<BenchFile> LoadBenchFile(const std::string& path, const std::string& bench) {
  TRY(const auto text, LoadText(path));
  return ParseBenchFile(text, path, bench);
}

std::unique_ptr<Daq> OpenDaq(const BenchFile& file) {
  LAB_CHECK(file.driver == BenchFile::Driver::kNiDaqmx ||
            file.driver == BenchFile::Driver::kComedi);
  ComediChannels comedi = file.comedi;
  comedi.relay_lines = file.config.wiring.mask();
  comedi.nominal_levels = file.config.wiring.nominal_levels();
  comedi.drive_zero_v = file.config.scaling.uc.ToTerminal(0.0);
  comedi.delta_s = file.config.description.delta_s;
  const ChannelScaling& scaling = file.config.scaling;
  const RigLimits& limits = file.config.limits;
  if (comedi.um >= 0) comedi.reach_v = TerminalReach(scaling.um, limits.voltage_v_max);
  if (comedi.ua >= 0) {
    comedi.reach_v = std::max(comedi.reach_v, TerminalReach(scaling.ua, limits.voltage_v_max));
  }
  if (comedi.ia >= 0) {
    comedi.reach_v = std::max(comedi.reach_v, TerminalReach(scaling.ia, limits.current_peak_a));
  }
  std::unique_ptr<Daq> driver = file.driver == BenchFile::Driver::kComedi
                                    ? OpenComedi(comedi)
                                    : OpenNiDaqmx(file.nidaqmx, file.config.scaling.speed);
  return MakeGuardedDaq(std::move(driver),
                        {.patience = file.driver_patience,
                         .drive_zero_v = file.config.scaling.uc.ToTerminal(0.0),
                         .fifo_priority = file.fifo_priority});
}

std::unique_ptr<RigMachine> OpenMachine(const BenchFile& file, std::shared_ptr<Clock> wall) {
  if (file.driver == BenchFile::Driver::kDevice) {
    return MakeDeviceMachine(file.config, file.device, std::move(wall));
  }
  return MakeBenchMachine(file.config, OpenDaq(file), nullptr, std::move(wall));
}

std::unique_ptr<Rig> OpenRig(const BenchFile& file, std::shared_ptr<Heartbeat> heartbeat) {
  if (file.driver == BenchFile::Driver::kSimulated) {
    SimulatedRigOptions options = file.simulated;
    options.id = file.config.description.id;
    return MakeSimulatedRig(std::move(options));
  }
  const std::shared_ptr<Clock> wall = MakeSteadyClock();
  const bool device = file.driver == BenchFile::Driver::kDevice;
  PacedRigOptions paced{.clock = device ? MakeFollowingClock() : MakeSteadyClock(),
                        .wall = wall,
                        .fifo_priority = file.fifo_priority};
  paced.consecutive_overruns_max = file.late_ticks_max;
  paced.heartbeat = std::move(heartbeat);
  return std::make_unique<PacedRig>(OpenMachine(file, wall), std::move(paced));
}

}  // namespace faultlab::hardware
