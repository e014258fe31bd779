#include "hardware/config/bench_file.h"

#include <toml++/toml.h>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/types/check.h"
#include "hardware/daq/guarded_daq.h"

namespace faultlab::hardware {
namespace {

/// Raised inside the parser, caught at its top.
struct Refusal {
  std::string key;
  std::string message;
  toml::source_region where;
};

std::string Text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

/// One table of the file; remembers which keys were asked for.
class Section {
 public:
  Section(const toml::table& table, std::string prefix)
      : table_(table), prefix_(std::move(prefix)) {}

  Section Sub(const std::string& key) {
    static const toml::table kEmpty;
    known_.insert(key);
    const toml::node* node = table_.get(key);
    if (node == nullptr) return {kEmpty, prefix_ + key + "."};
    if (!node->is_table()) Refuse(key, "is a table: [" + prefix_ + key + "]", node);
    return {*node->as_table(), prefix_ + key + "."};
  }

  void Number(const std::string& key, double& value, double min, double max) {
    const toml::node* node = Get(key);
    if (node == nullptr) return;
    const std::optional<double> number = node->value<double>();
    if (!number || node->is_boolean() || node->is_string()) Refuse(key, "must be a number", node);
    if (!(*number >= min && *number <= max)) {
      Refuse(key, "must lie between " + Text(min) + " and " + Text(max), node);
    }
    value = *number;
  }

  void Integer(const std::string& key, int& value, int min, int max) {
    const toml::node* node = Get(key);
    if (node == nullptr) return;
    const std::optional<std::int64_t> number =
        node->is_integer() ? node->value<std::int64_t>() : std::nullopt;
    if (!number) Refuse(key, "must be a whole number", node);
    if (*number < min || *number > max) {
      Refuse(key, "must lie between " + std::to_string(min) + " and " + std::to_string(max), node);
    }
    value = static_cast<int>(*number);
  }

  void Flag(const std::string& key, bool& value) {
    const toml::node* node = Get(key);
    if (node == nullptr) return;
    if (!node->is_boolean()) Refuse(key, "must be true or false", node);
    value = *node->value<bool>();
  }

  void String(const std::string& key, std::string& value) {
    const toml::node* node = Get(key);
    if (node == nullptr) return;
    if (!node->is_string()) Refuse(key, "must be a text in quotes", node);
    value = *node->value<std::string>();
  }

  /// Index of the word that stands there.
  int OneOf(const std::string& key, int fallback, const std::vector<std::string>& words) {
    std::string word;
    String(key, word);
    if (table_.get(key) == nullptr) return fallback;
    std::string all;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words[i] == word) return static_cast<int>(i);
      all += (i == 0 ? "" : ", ") + words[i];
    }
    Refuse(key, "must be one of " + all, table_.get(key));
  }

  void Lines(const std::string& key, std::array<int, core::kRelayPositions>& lines) {
    const toml::node* node = Get(key);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    if (array == nullptr || array->size() != lines.size()) {
      Refuse(key, "must be the four lines of its positions, nominal first", node);
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::optional<std::int64_t> line = array->get(i)->value<std::int64_t>();
      if (!array->get(i)->is_integer() || *line < 0 || *line > 31) {
        Refuse(key, "has a line that is not 0 to 31", array->get(i));
      }
      lines[i] = static_cast<int>(*line);
    }
  }

  void RefuseUnknown() const {
    for (const auto& [key, node] : table_) {
      if (!known_.contains(std::string(key.str()))) {
        Refuse(std::string(key.str()), "is not a key of this table", &node);
      }
    }
  }

  [[noreturn]] void Refuse(const std::string& key,
                           const std::string& what,
                           const toml::node* node) const {
    throw Refusal{.key = prefix_ + key,
                  .message = prefix_ + key + " " + what,
                  .where = node != nullptr ? node->source() : table_.source()};
  }

 private:
  const toml::node* Get(const std::string& key) {
    known_.insert(key);
    return table_.get(key);
  }

  const toml::table& table_;
  const std::string prefix_;
  std::set<std::string> known_;
};

void ReadScale(Section& section,
               const std::string& name,
               const std::string& unit,
               ChannelScale& s) {
  constexpr double kGainMax = 1e4;
  const std::string key = name + "_v_per_" + unit;
  double gain = s.v_per_unit;
  section.Number(key, gain, -kGainMax, kGainMax);
  if (gain == 0.0) section.Refuse(key, "must not be 0", nullptr);
  s.v_per_unit = gain;
  section.Number(name + "_offset_v", s.offset_v, -10.0, 10.0);
}

Nanoseconds Milliseconds(double value) {
  return Nanoseconds(std::llround(value * 1e6));
}

void ReadRelays(Section relays, BenchFile& file) {
  RelayWiring& wiring = file.config.wiring;
  relays.Flag("inverted", wiring.inverted);
  for (std::size_t board = 0; board < kRelayBoards; ++board) {
    relays.Lines(std::string(core::Name(kRelayComponents[board])), wiring.line[board]);
  }
  double gap_ms = 3.0;
  double settle_ms = 3.0;
  double rest_ms = 50.0;
  relays.Number("gap_ms", gap_ms, 0.5, 1000.0);
  relays.Number("settle_ms", settle_ms, 0.5, 1000.0);
  relays.Number("rest_ms", rest_ms, 10.0, 60000.0);
  file.config.timing = {.gap = Milliseconds(gap_ms), .settle = Milliseconds(settle_ms)};
  file.config.limits.relay_rest_s = rest_ms * 1e-3;
  std::set<int> used;
  for (std::size_t board = 0; board < kRelayBoards; ++board) {
    for (const int line : wiring.line[board]) {
      if (!used.insert(line).second) {
        relays.Refuse(std::string(core::Name(kRelayComponents[board])),
                      "uses line " + std::to_string(line) + ", which is in use already",
                      nullptr);
      }
    }
  }
  relays.RefuseUnknown();
}

void ReadLimits(Section limits, RigLimits& to) {
  limits.Number("uc_min_v", to.uc_v_min, -10.0, 0.0);
  limits.Number("uc_max_v", to.uc_v_max, 0.1, 10.0);
  limits.Number("slew_v_per_s", to.slew_v_per_s, 1.0, 1e6);
  limits.Number("voltage_max_v", to.voltage_v_max, 1.0, 60.0);
  limits.Number("current_continuous_a", to.current_continuous_a, 0.01, 20.0);
  limits.Number("current_peak_a", to.current_peak_a, 0.01, 100.0);
  limits.Number("thermal_tau_s", to.thermal_tau_s, 0.1, 1e4);
  limits.Number("stall_current_a", to.stall_current_a, 0.01, 100.0);
  limits.Number("stall_speed_rpm", to.stall_speed_rpm, 0.1, 1e4);
  limits.Number("stall_s", to.stall_s, 0.02, 60.0);
  limits.RefuseUnknown();
}

void ReadDriver(Section& root, BenchFile& file) {
  file.driver =
      static_cast<BenchFile::Driver>(root.OneOf("driver", 0, {"simulated", "nidaqmx", "comedi"}));
  Section simulated = root.Sub("simulated");
  file.simulated.profile =
      static_cast<SimulatedProfile>(simulated.OneOf("profile", 0, {"bench", "multisim"}));
  simulated.Number("speed", file.simulated.speed, 0.0, 1e6);
  simulated.RefuseUnknown();

  Section ni = root.Sub("nidaqmx");
  ni.String("library", file.nidaqmx.library);
  ni.String("drive", file.nidaqmx.drive);
  ni.String("um", file.nidaqmx.um);
  ni.String("ua", file.nidaqmx.ua);
  ni.String("ia", file.nidaqmx.ia);
  (void)ni.OneOf("terminal", 0, {"rse", "nrse", "diff"});
  ni.String("terminal", file.nidaqmx.terminal);
  ni.String("relays", file.nidaqmx.relays);
  ni.String("counter", file.nidaqmx.counter);
  ni.String("watchdog", file.nidaqmx.watchdog);
  double watchdog_ms = 200.0;
  ni.Number("watchdog_ms", watchdog_ms, 20.0, 10'000.0);
  file.nidaqmx.watchdog_s = watchdog_ms * 1e-3;
  ni.RefuseUnknown();

  Section comedi = root.Sub("comedi");
  comedi.String("library", file.comedi.library);
  comedi.String("device", file.comedi.device);
  const auto number = [&comedi](const char* key, int& value, int min) {
    comedi.Integer(key, value, min, 255);
  };
  number("analog_in", file.comedi.analog_in, 0);
  number("analog_out", file.comedi.analog_out, 0);
  number("digital", file.comedi.digital, 0);
  number("counter", file.comedi.counter, -1);
  number("drive", file.comedi.drive, 0);
  number("um", file.comedi.um, 0);
  number("ua", file.comedi.ua, -1);
  number("ia", file.comedi.ia, -1);
  number("counter_channel", file.comedi.counter_channel, 0);
  number("relay_base", file.comedi.relay_base, 0);
  number("range", file.comedi.range, 0);
  (void)comedi.OneOf("reference", 0, {"ground", "common", "diff"});
  comedi.String("reference", file.comedi.reference);
  comedi.RefuseUnknown();
}

BenchFile Read(const toml::table& table) {
  BenchFile file;
  Section root(table, "");
  RigDescription& description = file.config.description;
  description.rig_class = "bench";
  root.String("id", description.id);
  root.String("class", description.rig_class);
  root.String("calibration", file.calibration);
  ReadDriver(root, file);
  const bool simulated = file.driver == BenchFile::Driver::kSimulated;
  description.kind = simulated ? RigKind::kSimulated : RigKind::kBench;

  Section scaling = root.Sub("scaling");
  ReadScale(scaling, "uc", "v", file.config.scaling.uc);
  ReadScale(scaling, "um", "v", file.config.scaling.um);
  ReadScale(scaling, "ua", "v", file.config.scaling.ua);
  ReadScale(scaling, "ia", "a", file.config.scaling.ia);
  scaling.RefuseUnknown();

  Section encoder = root.Sub("encoder");
  encoder.Integer("pulses_per_revolution", file.config.scaling.pulses_per_revolution, 1, 100000);
  encoder.Number("gear_ratio", file.config.scaling.gear_ratio, 0.01, 1000.0);
  const bool comedi = file.driver == BenchFile::Driver::kComedi;
  file.config.scaling.speed =
      static_cast<SpeedMethod>(encoder.OneOf("method", comedi ? 1 : 0, {"frequency", "count"}));
  if (comedi && file.config.scaling.speed == SpeedMethod::kPulseFrequency) {
    encoder.Refuse("method", "must be \"count\": Comedi has no frequency", table.get("encoder"));
  }
  encoder.RefuseUnknown();

  ReadRelays(root.Sub("relays"), file);
  ReadLimits(root.Sub("limits"), file.config.limits);

  Section amplifier = root.Sub("amplifier");
  description.amplifier_mode =
      static_cast<core::AmplifierMode>(amplifier.OneOf("mode", 0, {"voltage", "current"}));
  int quadrants = 2;
  amplifier.Integer("quadrants", quadrants, 2, 4);
  if (quadrants == 3) amplifier.Refuse("quadrants", "must be 2 or 4", nullptr);
  description.amplifier_quadrants = quadrants == 4 ? core::Quadrants::kFour : core::Quadrants::kTwo;
  if (quadrants == 2 && file.config.limits.uc_v_min < 0.0) {
    amplifier.Refuse("quadrants", "is 2, but limits.uc_min_v is below 0", nullptr);
  }
  amplifier.RefuseUnknown();

  Section loop = root.Sub("loop");
  double delta_ms = 9.5;
  loop.Number("delta_ms", delta_ms, 0.1, 1000.0);
  description.delta_s = delta_ms * 1e-3;
  loop.Integer("fifo_priority", file.fifo_priority, 0, 99);
  loop.Integer("late_ticks_max", file.late_ticks_max, 1, 1000);
  double driver_timeout_ms = 250.0;
  loop.Number("driver_timeout_ms", driver_timeout_ms, 20.0, 10'000.0);
  file.driver_patience = Milliseconds(driver_timeout_ms);
  loop.RefuseUnknown();
  if (!simulated && file.config.timing.gap + file.config.timing.settle >= Milliseconds(delta_ms)) {
    loop.Refuse("delta_ms",
                "is shorter than relays.gap_ms + relays.settle_ms: the sample would be read while "
                "relays move",
                nullptr);
  }

  Section link = root.Sub("link");
  link.Number("ride_through_s", file.ride_through_s, 0.0, 120.0);
  link.RefuseUnknown();
  root.RefuseUnknown();

  description.has_ua = simulated || (comedi ? file.comedi.ua >= 0 : !file.nidaqmx.ua.empty());
  description.has_ia = simulated || (comedi ? file.comedi.ia >= 0 : !file.nidaqmx.ia.empty());
  description.has_n =
      simulated || (comedi ? file.comedi.counter >= 0 : !file.nidaqmx.counter.empty());
  file.simulated.rig_class = description.rig_class;
  file.simulated.amplifier_mode = description.amplifier_mode;
  file.simulated.amplifier_quadrants = description.amplifier_quadrants;
  file.simulated.gated_speed = file.config.scaling.speed == SpeedMethod::kGatedCount;
  return file;
}

}  // namespace

core::Result<BenchFile> ParseBenchFile(std::string_view text, std::string_view name) {
  const auto refuse = [&](const toml::source_region& where, std::string message, std::string key) {
    return core::Error{.code = core::ErrorCode::kInvalid,
                       .message = std::string(name) + ":" + std::to_string(where.begin.line) +
                                  ": " + std::move(message),
                       .field = std::move(key)};
  };
  try {
    return Read(toml::parse(text, name));
  } catch (const toml::parse_error& error) {
    return refuse(error.source(), std::string(error.description()), "");
  } catch (const Refusal& refusal) {
    return refuse(refusal.where, refusal.message, refusal.key);
  }
}

core::Result<BenchFile> LoadBenchFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return core::Error{
        .code = core::ErrorCode::kNotFound, .message = path + " cannot be read", .field = {}};
  }
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  return ParseBenchFile(text, path);
}

std::unique_ptr<Daq> OpenDaq(const BenchFile& file) {
  LAB_CHECK(file.driver != BenchFile::Driver::kSimulated);
  ComediChannels comedi = file.comedi;
  comedi.relay_lines = file.config.wiring.mask();
  std::unique_ptr<Daq> driver = file.driver == BenchFile::Driver::kComedi
                                    ? OpenComedi(comedi)
                                    : OpenNiDaqmx(file.nidaqmx, file.config.scaling.speed);
  return MakeGuardedDaq(std::move(driver),
                        {.patience = file.driver_patience,
                         .drive_zero_v = file.config.scaling.uc.ToTerminal(0.0),
                         .fifo_priority = file.fifo_priority});
}

std::unique_ptr<Rig> OpenRig(const BenchFile& file, std::shared_ptr<Heartbeat> heartbeat) {
  if (file.driver == BenchFile::Driver::kSimulated) {
    SimulatedRigOptions options = file.simulated;
    options.id = file.config.description.id;
    return MakeSimulatedRig(std::move(options));
  }
  const std::shared_ptr<Clock> wall = MakeSteadyClock();
  PacedRigOptions paced{
      .clock = MakeSteadyClock(), .wall = wall, .runner = MakeThreadRunner(file.fifo_priority)};
  paced.consecutive_overruns_max = file.late_ticks_max;
  paced.heartbeat = std::move(heartbeat);
  return std::make_unique<PacedRig>(MakeBenchMachine(file.config, OpenDaq(file), nullptr, wall),
                                    std::move(paced));
}

}  // namespace faultlab::hardware
