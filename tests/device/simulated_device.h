#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "hardware/clock.h"
#include "hardware/device/frame.h"
#include "tests/device/bench_at_pins.h"

namespace faultlab::hardware {

/// The firmware in simavr, the simulated bench at its pins, and a line to it: a TCP port (a serial
/// line behind an adapter) or a pseudo-terminal. Time passes only when somebody lets it pass:
/// clock() for lockstep, RunInRealTime for programs that know nothing of it. Thread-safe.
class SimulatedDevice {
 public:
  enum class Line { kSerialServer, kTcp, kTerminal };

  explicit SimulatedDevice(Line line);
  ~SimulatedDevice();
  SimulatedDevice(const SimulatedDevice&) = delete;
  SimulatedDevice& operator=(const SimulatedDevice&) = delete;

  /// For the rig file's [device] port.
  const std::string& port() const { return port_; }
  /// Sleeping on it runs the device until then: a machine's load changes no result.
  std::shared_ptr<Clock> clock();
  void RunUntil(Nanoseconds time);
  Nanoseconds now();
  /// Follows the wall clock from now on, but not faster after it was held up.
  void RunInRealTime();

  /// Bytes no longer pass, in neither direction; what is sent is lost. @returns when.
  Nanoseconds CutCable(bool cut);
  /// The line is closed by the other side.
  void HangUp();
  Nanoseconds PressReset();
  /// Bytes from nowhere, towards the device or from it.
  void InjectToDevice(std::string bytes);
  void InjectToHost(std::string bytes);
  /// Each byte, in both directions, is hit with this probability.
  void SetNoise(double probability);
  int noise_hits();
  /// A and B are exchanged.
  void SwapEncoder();
  /// An encoder input that rings: an interrupt for each few instructions.
  void FloodEncoder(bool on);
  void StickLines(std::uint32_t connected);

  /// Volts at the output of uc, and the lines that are connected, at this moment.
  double drive_v();
  std::uint32_t lines();
  RelayAbuse abuse();
  /// Drive 0 and the nominal lines, at the pins.
  bool IsSafe();
  /// When uc became 0 V last.
  Nanoseconds drive_zero_at();
  /// Share of the time that the processor did not sleep, since the last call.
  double load();
  std::uint64_t uart_overruns();
  /// The processor ran until now.
  bool alive();

 private:
  void Run(std::uint64_t cycle);
  void MoveBytes();
  void TakeConnection();
  void Hit(std::string& bytes);
  void FromHost(std::string_view bytes);
  void ToHost(std::string_view bytes);

  const Line line_;
  std::mutex mutex_;
  std::string port_;
  int listener_ = -1;
  int peer_ = -1;      ///< of the TCP connection, or the terminal's master
  int terminal_ = -1;  ///< the slave, held open so that a closing host ends nothing
  bool cut_ = false;
  bool alive_ = true;
  double noise_ = 0.0;
  std::uint32_t noise_state_ = 12345;
  int noise_hits_ = 0;
  std::string to_host_;
  std::unique_ptr<Framing> from_host_framing_;  ///< of kTcp
  std::unique_ptr<Framing> to_host_framing_;
  std::uint64_t busy_before_ = 0;
  std::uint64_t cycle_before_ = 0;
  std::unique_ptr<BenchAtPins> bench_;
  std::atomic<bool> ending_{false};
  std::thread real_time_;
};

}  // namespace faultlab::hardware
