#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/bench/profile.h"
#include "core/plant/converters.h"
#include "core/plant/plant.h"
#include "hardware/clock.h"
#include "hardware/daq/channel_scaling.h"
#include "hardware/daq/daq.h"
#include "hardware/relay_board.h"
#include "hardware/simulator_port.h"

namespace faultlab::hardware {

/// What relay lines did that a bench would not have survived.
struct RelayAbuse {
  int two_connected = 0;  ///< two parts at once where one breaks before the next makes
  int left_open = 0;      ///< none where the circuit must never be open
};

/// A Daq answered by core's plant: 16-bit converters, encoder pulses, inverted relay lines. The
/// plant is advanced to the clock's time at each call; contacts take effect when time passes.
/// An open contact is a resistor of kOpenOhm or no capacitor; two connected parts
/// are in parallel.
class SimulatedDaq final : public Daq, public SimulatorPort {
 public:
  SimulatedDaq(const core::Bench& bench,
               core::BenchProfile profile,
               ChannelScaling scaling,
               RelayWiring wiring,
               std::shared_ptr<const Clock> clock);

  double WriteDrive(double terminal_v) override;
  AnalogReading ReadAnalog() override;
  void WriteRelayLines(std::uint32_t levels) override;
  std::uint32_t ReadRelayLines() override { return levels_; }
  double ReadPulseFrequencyHz() override;
  std::uint32_t ReadPulseCount() override;
  void Prepare() override {}
  void FeedWatchdog() override {}
  bool has_watchdog() const override { return false; }

  void BeginRun(std::uint64_t seed) override;
  void Set(core::Component component, double value) override;
  void Drift(core::Component component, double value) override;
  void Clear(core::Component component) override;

  const RelayAbuse& abuse() const { return abuse_; }
  const core::Plant& plant() const { return plant_; }
  double drive_v() const { return drive_v_; }

 private:
  void Sync();
  void ApplyContacts();
  double ContactValue(std::size_t board) const;

  const core::Bench& bench_;
  const core::BenchProfile profile_;
  const ChannelScaling scaling_;
  const RelayWiring wiring_;
  const std::shared_ptr<const Clock> clock_;
  core::Plant plant_;
  core::MeasurementNoise noise_;
  Nanoseconds advanced_to_{0};
  double drive_v_ = 0.0;
  std::uint32_t levels_ = 0xffffffffu;
  bool contacts_changed_ = true;
  std::array<std::optional<double>, core::kComponentsMax> off_table_{};
  RelayAbuse abuse_;
};

}  // namespace faultlab::hardware
