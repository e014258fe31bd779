#pragma once

#include <memory>
#include <string_view>

#include "hardware/daq/channel_scaling.h"
#include "hardware/daq/daq.h"
#include "hardware/paced_rig.h"
#include "hardware/relay_board.h"
#include "hardware/rig_limits.h"
#include "hardware/rig_machine.h"
#include "hardware/simulator_port.h"

namespace faultlab::hardware {

/// Name of the trip of a driver call that does not return.
inline constexpr std::string_view kDriverHang = "driver_hang";

/// Everything about a bench but its driver.
struct BenchConfig {
  RigDescription description;
  ChannelScaling scaling;
  RelayWiring wiring;
  RelayTiming timing;
  RigLimits limits;
};

/// A rig as its class is described, in everything that the description says.
BenchConfig ConfigOf(const core::Bench& bench);

/// A bench as a machine: Daq + RelayBoard + limits. One tick of sample k:
///
///   t_k               commands and faults that are due -> relay stages; uc(k) -> DAC
///   t_k + gap ..      further relay stages, read back -> kRelayConfirmed or trip
///   t_k + delta       ADC, counter -> Sample k -> interlocks
///
/// A commanded value that a relay connects goes through the board; others need `port`. A board
/// that has just switched rests relay_rest_s: the newest command waits for that.
///
/// @param port  of a simulator, or null; belongs to the daq
/// @param wall  for waits outside a run and the cooling between runs; null on a simulator, which
///              starts each run with a fresh motor
/// Throws core::ContractError for a config whose relays do not settle before the ADC.
std::unique_ptr<RigMachine> MakeBenchMachine(BenchConfig config,
                                             std::unique_ptr<Daq> daq,
                                             SimulatorPort* port,
                                             std::shared_ptr<Clock> wall);

}  // namespace faultlab::hardware
