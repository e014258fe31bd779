#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "hardware/bench_rig.h"
#include "hardware/comedi/comedi_daq.h"
#include "hardware/device/device_port.h"
#include "hardware/heartbeat.h"
#include "hardware/nidaqmx/nidaqmx_daq.h"
#include "hardware/simulated/simulated_rig.h"

namespace faultlab::hardware {

/// A far simulator whose description names no class has that of its bench and this: it needs a
/// session, as the server's own simulators do not, and is no bench.
inline constexpr const char* kFarSimulators = "-far-sim";

/// A bench's configuration file (TOML): what hardware/README.md explains key by key.
struct BenchFile {
  enum class Driver { kSimulated, kNiDaqmx, kComedi, kDevice };

  Driver driver = Driver::kSimulated;
  BenchConfig config;  ///< scaling, relays, limits, description
  SimulatedRigOptions simulated;
  NiDaqmxChannels nidaqmx;
  ComediChannels comedi;
  DeviceAddress device;
  std::string calibration;
  double ride_through_s = 0.0;
  int fifo_priority = 50;
  int late_ticks_max = 5;
  Nanoseconds driver_patience = std::chrono::milliseconds(250);
};

/// Every key is checked for type and range, unknown ones are refused. An Error's message begins
/// "NAME:LINE: "; its field is the dotted key.
/// @param bench  description that stands for the file's own `bench`; empty: as the file says
core::Result<BenchFile> ParseBenchFile(std::string_view text,
                                       std::string_view name,
                                       const std::string& bench = "");
core::Result<BenchFile> LoadBenchFile(const std::string& path, const std::string& bench = "");

/// The board itself, opened. Throws IoError. Contract: driver is kNiDaqmx or kComedi.
std::unique_ptr<Daq> OpenDaq(const BenchFile& file);
/// The bench behind its board or device, opened: of a rig, or to make it safe once more. Throws
/// IoError, core::ContractError. Contract: driver is not kSimulated.
std::unique_ptr<RigMachine> OpenMachine(const BenchFile& file, std::shared_ptr<Clock> wall);
/// The rig that the file describes, paced by real time. A simulated one has no heartbeat: nothing
/// is driven. Throws IoError, core::ContractError.
std::unique_ptr<Rig> OpenRig(const BenchFile& file, std::shared_ptr<Heartbeat> heartbeat = nullptr);

}  // namespace faultlab::hardware
