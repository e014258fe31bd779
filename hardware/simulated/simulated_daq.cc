#include "hardware/simulated/simulated_daq.h"

#include <algorithm>
#include <utility>

#include "core/signals/random.h"

namespace faultlab::hardware {
namespace {

constexpr double kOpenOhm = 1e7;
constexpr double kOpenFarad = 1e-15;
/// The plant takes steps of at most 1 s.
constexpr double kStepMaxS = 1.0;

bool IsCapacitor(core::Component component) {
  return component.info().kind == core::PartKind::kCapacitor;
}

}  // namespace

SimulatedDaq::SimulatedDaq(const core::Bench& bench,
                           core::BenchProfile profile,
                           ChannelScaling scaling,
                           RelayWiring wiring,
                           std::shared_ptr<const Clock> clock)
    : bench_(bench),
      profile_(std::move(profile)),
      scaling_(scaling),
      wiring_(std::move(wiring)),
      clock_(std::move(clock)),
      plant_(bench_.nominal, profile_, 0),
      noise_(profile_.noise, 0) {}

void SimulatedDaq::BeginRun(std::uint64_t seed) {
  plant_ = core::Plant(bench_.nominal, profile_, core::StreamSeed(seed, 0));
  noise_ = core::MeasurementNoise(profile_.noise, core::StreamSeed(seed, 1));
  advanced_to_ = clock_->Now();
  off_table_ = {};
  contacts_changed_ = true;
  plant_.SetInput(scaling_.uc.ToUnit(drive_v_));
}

void SimulatedDaq::Sync() {
  const Nanoseconds now = clock_->Now();
  if (now <= advanced_to_) return;
  ApplyContacts();
  // Division, not multiplication by 1e-9: 9.5 ms is then the same double as the literal.
  double remaining_s = static_cast<double>((now - advanced_to_).count()) / 1e9;
  advanced_to_ = now;
  while (remaining_s > 0.0) {
    const double step_s = std::min(remaining_s, kStepMaxS);
    plant_.Advance(step_s);
    remaining_s -= step_s;
  }
}

double SimulatedDaq::ContactValue(std::size_t board) const {
  const core::Component component = wiring_.boards[board];
  const std::uint32_t connected = wiring_.inverted ? ~levels_ : levels_;
  double sum = 0.0;  // of conductances, or of capacitances
  int count = 0;
  double only = 0.0;
  for (const core::SwitchPosition& position : component.info().positions) {
    if ((connected & (1u << position.line)) == 0) continue;
    ++count;
    only = position.value;
    sum += IsCapacitor(component) ? only : 1.0 / only;
  }
  if (count == 0) return IsCapacitor(component) ? kOpenFarad : kOpenOhm;
  if (count == 1) return only;
  return IsCapacitor(component) ? sum : 1.0 / sum;
}

void SimulatedDaq::ApplyContacts() {
  if (!contacts_changed_) return;
  contacts_changed_ = false;
  for (std::size_t board = 0; board < wiring_.boards.size(); ++board) {
    const core::Component component = wiring_.boards[board];
    if (off_table_[static_cast<std::size_t>(core::Index(component))]) continue;
    plant_.Set(component, ContactValue(board));
  }
}

double SimulatedDaq::WriteDrive(double terminal_v) {
  Sync();
  drive_v_ = core::Convert(terminal_v, profile_.converters.range_v);
  plant_.SetInput(scaling_.uc.ToUnit(drive_v_));
  return drive_v_;
}

AnalogReading SimulatedDaq::ReadAnalog() {
  Sync();
  const core::PlantOutputs outputs = plant_.outputs();
  const double um_v = noise_.um_v(outputs.um_v);
  const double ua_v = noise_.ua_v(outputs.ua_v);
  const double ia_a = noise_.ia_a(outputs.ia_a);
  const double range_v = profile_.converters.range_v;
  return {.um_v = core::Convert(scaling_.um.ToTerminal(um_v), range_v),
          .ua_v = core::Convert(scaling_.ua.ToTerminal(ua_v), range_v),
          .ia_v = core::Convert(scaling_.ia.ToTerminal(ia_a), range_v)};
}

void SimulatedDaq::WriteRelayLines(std::uint32_t levels) {
  Sync();
  levels_ = levels;
  contacts_changed_ = true;
  const std::uint32_t connected = wiring_.inverted ? ~levels : levels;
  for (std::size_t board = 0; board < wiring_.boards.size(); ++board) {
    int count = 0;
    const core::ComponentInfo& part = wiring_.boards[board].info();
    for (const core::SwitchPosition& position : part.positions) {
      count += (connected >> position.line) & 1u ? 1 : 0;
    }
    if (part.order == core::SwitchOrder::kMakeBeforeBreak) {
      abuse_.left_open += count == 0 ? 1 : 0;
    } else {
      abuse_.two_connected += count > 1 ? 1 : 0;
    }
  }
}

double SimulatedDaq::ReadPulseFrequencyHz() {
  Sync();
  const double n_rpm = noise_.n_rpm(core::SpeedReadingRpm(
      plant_.outputs().omega_rad_s, profile_.converters, bench_.nominal.gear_ratio));
  return n_rpm * scaling_.pulses_per_revolution * scaling_.gear_ratio / 60.0;
}

std::uint32_t SimulatedDaq::ReadPulseCount() {
  Sync();
  return static_cast<std::uint32_t>(
      core::EncoderPulses(plant_.outputs().angle_rad, profile_.converters.pulses_per_revolution));
}

void SimulatedDaq::Set(core::Component component, double value) {
  Sync();
  off_table_[static_cast<std::size_t>(core::Index(component))] = value;
  plant_.Set(component, value);
}

void SimulatedDaq::Drift(core::Component component, double value) {
  Sync();
  off_table_[static_cast<std::size_t>(core::Index(component))] = value;
  plant_.Drift(component, value);
}

void SimulatedDaq::Clear(core::Component component) {
  Sync();
  off_table_[static_cast<std::size_t>(core::Index(component))].reset();
  if (core::IsSwitched(component)) {
    contacts_changed_ = true;
  } else {
    plant_.Set(component, bench_.nominal.Get(component));
  }
}

}  // namespace faultlab::hardware
