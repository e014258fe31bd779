#include "tests/device/bench_at_pins.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/types/check.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

constexpr std::uint64_t kSliceCycles = 4000;  ///< 250 us
constexpr std::uint32_t kRelays = 0x00ff00ffu;
/// rms at the converters, so that four readings are worth more than one.
constexpr double kNoiseMv = 3.0;

constexpr std::uint8_t Bit(int bit) {
  return static_cast<std::uint8_t>(1u << bit);
}
constexpr std::uint8_t kDacSelect = Bit(2), kDacData = Bit(3), kDacClock = Bit(5);
constexpr std::uint8_t kRelayData = Bit(3), kRelayClock = Bit(4), kRelayLatch = Bit(5);
constexpr std::uint8_t kRelayOff = Bit(4), kRelayLoad = Bit(5);
constexpr int kReadBackPin = 6;

bool Rises(std::uint8_t before, std::uint8_t now, std::uint8_t bit) {
  return (before & bit) == 0 && (now & bit) != 0;
}

/// Its supply and noise, but the encoder and the converters are those of the board.
core::BenchProfile QuietProfile() {
  core::BenchProfile profile = paper::Hardware();
  profile.noise = {};
  return profile;
}

}  // namespace

class BenchAtPins::ChipClock final : public Clock {
 public:
  explicit ChipClock(const BenchAtPins& bench) : bench_(bench) {}
  Nanoseconds Now() const override {
    if (bench_.chip_ == nullptr) return Nanoseconds(0);
    return Nanoseconds(static_cast<std::int64_t>(avr_chip_cycle(bench_.chip_) * 125 / 2));
  }
  Wake SleepUntil(Nanoseconds) override { return {}; }

 private:
  const BenchAtPins& bench_;
};

ChannelScaling BenchAtPins::Scaling() {
  ChannelScaling scaling = ScalingOf(paper::Bench());
  scaling.um = {.v_per_unit = 0.4, .offset_v = 0.0};
  scaling.ua = {.v_per_unit = 0.4, .offset_v = 0.0};
  scaling.ia = {.v_per_unit = 2.0, .offset_v = 1.0};
  return scaling;
}

BenchAtPins::BenchAtPins(const std::string& firmware)
    : clock_(std::make_shared<ChipClock>(*this)),
      plant_(std::make_unique<SimulatedDaq>(
          paper::Bench(), QuietProfile(), Scaling(), WiringOf(paper::Bench()), clock_)) {
  const avr_chip_wiring wiring{
      .context = this,
      .sent = [](void* c,
                 std::uint8_t byte) { Self(c).from_device.push_back(static_cast<char>(byte)); },
      .receive =
          [](void* c) {
            std::deque<std::uint8_t>& bytes = Self(c).to_device;
            if (bytes.empty()) return -1;
            const int byte = bytes.front();
            bytes.pop_front();
            return byte;
          },
      .port =
          [](void* c, char port, std::uint8_t value, std::uint8_t direction) {
            Self(c).OnPort(port, value, direction);
          },
      .convert = [](void* c) { Self(c).OnConvert(); },
      .woken = [](void* c, std::uint64_t cycle) { Self(c).OnWake(cycle); },
      .reset = [](void* c) { Self(c).OnReset(); }};
  plant_->BeginRun(1);
  chip_ = avr_chip_open(firmware.c_str(), &wiring);
  LAB_CHECK(chip_ != nullptr, firmware);
  OnReset();
}

BenchAtPins::~BenchAtPins() {
  avr_chip_close(chip_);
}

void BenchAtPins::OnPort(char port, std::uint8_t value, std::uint8_t direction) {
  if (port == 'B') OnDacPort(std::exchange(port_b_, value), value);
  if (port == 'C') OnRelayPort(std::exchange(port_c_, value), value);
  if (port == 'D') OnControlPort(value, direction);
}

void BenchAtPins::OnDacPort(std::uint8_t before, std::uint8_t now) {
  if ((now & kDacSelect) == 0 && Rises(before, now, kDacClock)) {
    dac_shift_ = static_cast<std::uint16_t>(dac_shift_ << 1 | ((now & kDacData) != 0 ? 1 : 0));
    ++dac_bits_;
  }
  if (!Rises(before, now, kDacSelect)) return;
  if (dac_bits_ == 16 && (dac_shift_ & 0xf000u) == 0x3000u) {
    const double volt = (dac_shift_ & 0x0fffu) * 5.0 / 4096.0;
    if (volt == 0.0 && drive_v_ != 0.0) drive_zero_at_ = avr_chip_cycle(chip_);
    drive_v_ = volt;
    plant_->WriteDrive(drive_v_);
  }
  dac_bits_ = 0;
}

void BenchAtPins::OnRelayPort(std::uint8_t before, std::uint8_t now) {
  if (Rises(before, now, kRelayClock)) {
    relay_shift_ = relay_shift_ << 1 | ((now & kRelayData) != 0 ? 1u : 0u);
    read_shift_ <<= 1;
    ShowReadBack();
  }
  if (Rises(before, now, kRelayLatch)) {
    relay_latch_ = relay_shift_;
    MoveContacts();
  }
}

void BenchAtPins::OnControlPort(std::uint8_t value, std::uint8_t direction) {
  port_d_ = value;
  const bool off = (direction & kRelayOff) == 0 || (value & kRelayOff) != 0;
  if (off != relays_off_) {
    relays_off_ = off;
    MoveContacts();
  }
  if ((value & kRelayLoad) == 0) {
    read_shift_ = ~contacts_;
    ShowReadBack();
  }
}

void BenchAtPins::ShowReadBack() {
  avr_chip_set_pin(chip_, 'D', kReadBackPin, (read_shift_ & 0x80000000u) != 0 ? 1 : 0);
}

void BenchAtPins::MoveContacts() {
  const std::uint32_t driven = relays_off_ ? kNominal : ~relay_latch_ & kRelays;
  contacts_ = driven | stuck_connected_;
  plant_->WriteRelayLines(~contacts_);
}

void BenchAtPins::OnConvert() {
  const AnalogReading volts = plant_->ReadAnalog();
  const double inputs[] = {volts.um_v, volts.ua_v, volts.ia_v};
  for (int channel = 0; channel < 3; ++channel) {
    const double mv = 1e3 * inputs[channel] + kNoiseMv * noise_.Normal();
    avr_chip_set_millivolts(
        chip_, channel, static_cast<int>(std::lround(std::clamp(mv, 0.0, 5000.0))));
  }
}

/// One quarter of a pulse at most, then the next wake-up: at the next quarter or at the next look
/// at the motor.
void BenchAtPins::OnWake(std::uint64_t cycle) {
  if (flooded_) {
    encoder_a_ = !encoder_a_;
    avr_chip_set_pin(chip_, 'D', 2, encoder_a_ ? 1 : 0);
    avr_chip_wake_at(chip_, cycle + 20);
    return;
  }
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const int per_revolution = paper::Bench().pulses_per_revolution;
  if (cycle >= sliced_at_ + kSliceCycles) {
    sliced_at_ = cycle;
    (void)plant_->ReadPulseCount();  // moves the motor to this moment
    const core::PlantOutputs motor = plant_->plant().outputs();
    angle_quarters_ = motor.angle_rad / kTurn * per_revolution * 4;
    quarters_per_cycle_ = motor.omega_rad_s / kTurn * per_revolution * 4 / kCyclesPerS;
  }
  const double now =
      angle_quarters_ + quarters_per_cycle_ * static_cast<double>(cycle - sliced_at_);
  const auto reached = static_cast<std::int64_t>(std::floor(now));
  if (reached != quarter_) {
    quarter_ += reached > quarter_ ? 1 : -1;
    // Forwards: A rises while B is low.
    const auto phase = static_cast<unsigned>(quarter_) & 3u;
    const bool a = phase == 1 || phase == 2;
    const bool b = phase == 2 || phase == 3;
    const bool clock = swapped_ ? b : a;
    if (clock && !encoder_a_) avr_chip_set_pin(chip_, 'D', 3, (swapped_ ? a : b) ? 1 : 0);
    encoder_a_ = clock;
    avr_chip_set_pin(chip_, 'D', 2, clock ? 1 : 0);
  }
  std::uint64_t next = sliced_at_ + kSliceCycles;
  if (reached != quarter_) {
    next = cycle + 16;
  } else if (quarters_per_cycle_ > 0.0) {
    const double left = (static_cast<double>(quarter_ + 1) - now) / quarters_per_cycle_;
    next = std::min(next, cycle + 1 + static_cast<std::uint64_t>(left));
  }
  avr_chip_wake_at(chip_, next);
}

/// The converter holds its code; /OE goes high.
void BenchAtPins::OnReset() {
  port_b_ = port_c_ = 0;
  dac_bits_ = 0;
  if (chip_ == nullptr) return;
  OnControlPort(0, 0);
  MoveContacts();
  avr_chip_wake_at(chip_, avr_chip_cycle(chip_) + 100);
}

}  // namespace faultlab::hardware
