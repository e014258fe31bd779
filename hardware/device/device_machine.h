#pragma once

#include <memory>
#include <string_view>

#include "hardware/bench_rig.h"
#include "hardware/device/device_port.h"
#include "hardware/rig.h"
#include "hardware/rig_machine.h"

namespace faultlab::hardware {

/// Trips that only a device has; the table in hardware/README.md says what to do.
inline constexpr std::string_view kDeviceLost = "device_lost";
inline constexpr std::string_view kDeviceReset = "device_reset";
inline constexpr std::string_view kDeviceFault = "device_fault";

/// How the host treats a device.
struct DeviceTiming {
  /// Without a word of this program the device makes itself safe.
  Nanoseconds watchdog = std::chrono::milliseconds(250);
  /// Without a word of the device the run ends.
  Nanoseconds silence = std::chrono::milliseconds(250);
  /// Relays are commanded this long before the sample on which they act.
  Nanoseconds lead = std::chrono::milliseconds(60);
  Nanoseconds heartbeat = std::chrono::milliseconds(50);
  /// For HELLO: a board that has just got its power boots first.
  Nanoseconds connect = std::chrono::seconds(3);
};

/// A bench whose device keeps the clock (PROTOCOL.md). Limits, interlocks, fault injector and relay
/// positions are those of every bench; the device puts out the plan, switches relays on the sample
/// that it is told, reads at t_k + delta, and makes itself safe when it hears nothing.
///
///   Prepare    PLAN, DATA until its buffer is full
///   Step 1     ARM, RELAY of the first samples, START
///   Step ..    samples -> interlocks; RELAY of sample k + lead; DATA; HEARTBEAT; RESEND of a
///              sample that did not arrive
///
/// Sample::t_s is device time. The loop that calls Step keeps no time: it only has to come round
/// several times within `watchdog`.
/// Connects at once: throws IoError when no device answers, or one that is wired otherwise than the
/// bench is described.
std::unique_ptr<RigMachine> MakeDeviceMachine(BenchConfig config,
                                              DeviceAddress address,
                                              std::shared_ptr<Clock> clock,
                                              DeviceTiming timing = {});

}  // namespace faultlab::hardware
