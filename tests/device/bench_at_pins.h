#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "core/signals/random.h"
#include "hardware/simulated/simulated_daq.h"
#include "tests/device/avr_chip.h"

namespace faultlab::hardware {

/// The board of firmware/atmega328p around the chip, and the paper's bench behind it: an MCP4921,
/// four 74HC595 with the resistors that choose the nominal parts when /OE is high, four 74HC165
/// that read the contacts, the encoder with the flip-flop that holds its sense, dividers at the
/// converters.
class BenchAtPins {
 public:
  /// How the simulated bench is wired to 0 .. 5 V: the [scaling] of a rig file.
  static ChannelScaling Scaling();

  explicit BenchAtPins(const std::string& firmware);
  ~BenchAtPins();
  BenchAtPins(const BenchAtPins&) = delete;
  BenchAtPins& operator=(const BenchAtPins&) = delete;

  avr_chip* chip() { return chip_; }
  static constexpr double kCyclesPerS = 16e6;
  /// The lines of the nominal parts.
  static constexpr std::uint32_t kNominal = 1u << 17 | 1u << 19 | 1u << 21 | 1u << 6;

  std::deque<std::uint8_t> to_device;
  std::string from_device;

  /// These relays stay closed from now on.
  void StickLines(std::uint32_t connected) {
    stuck_connected_ = connected;
    MoveContacts();
  }
  void FloodEncoder(bool on) { flooded_ = on; }
  void SwapEncoder() { swapped_ = !swapped_; }
  double drive_v() const { return drive_v_; }
  /// Cycle at which uc became 0 V last.
  std::uint64_t drive_zero_at() const { return drive_zero_at_; }
  /// 1: the line connects its part.
  std::uint32_t lines() const { return contacts_; }
  const RelayAbuse& abuse() const { return plant_->abuse(); }

 private:
  class ChipClock;

  static BenchAtPins& Self(void* context) { return *static_cast<BenchAtPins*>(context); }

  void OnPort(char port, std::uint8_t value, std::uint8_t direction);
  void OnDacPort(std::uint8_t before, std::uint8_t now);
  void OnRelayPort(std::uint8_t before, std::uint8_t now);
  void OnControlPort(std::uint8_t value, std::uint8_t direction);
  void ShowReadBack();
  void MoveContacts();
  void OnConvert();
  void OnWake(std::uint64_t cycle);
  void OnReset();

  avr_chip* chip_ = nullptr;
  std::shared_ptr<ChipClock> clock_;
  std::unique_ptr<SimulatedDaq> plant_;
  core::Random noise_{7};

  std::uint8_t port_b_ = 0;
  std::uint8_t port_c_ = 0;
  std::uint8_t port_d_ = 0;
  std::uint16_t dac_shift_ = 0;
  int dac_bits_ = 0;
  double drive_v_ = 0.0;
  std::uint64_t drive_zero_at_ = 0;
  std::uint32_t relay_shift_ = 0;
  std::uint32_t relay_latch_ = 0xffffffffu;
  bool relays_off_ = true;  ///< /OE high
  std::uint32_t contacts_ = 0;
  std::uint32_t stuck_connected_ = 0;
  std::uint32_t read_shift_ = 0;

  bool swapped_ = false;
  bool flooded_ = false;
  bool encoder_a_ = false;
  std::int64_t quarter_ = 0;  ///< of an encoder pulse, as shown at the pins
  double angle_quarters_ = 0.0;
  double quarters_per_cycle_ = 0.0;
  std::uint64_t sliced_at_ = 0;
};

}  // namespace faultlab::hardware
