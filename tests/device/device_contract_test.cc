// The contract of a Rig, kept by a device: its firmware in simavr, over TCP in lockstep.
#include "tests/device/device_rigs.h"
#include "tests/hardware/rig_contract.h"

namespace faultlab::hardware {
namespace {

/// Of the rig that the test has; the rig before is closed when this is replaced.
std::unique_ptr<SimulatedDevice> the_device;

std::unique_ptr<Rig> MakeDevice(SimulatedDevice::Line line) {
  the_device.reset();
  the_device = std::make_unique<SimulatedDevice>(line);
  return MakeLockstepRig(*the_device);
}

const RigUnderContract kDevices[] = {
    {"DeviceBySerialLine",
     [] { return MakeDevice(SimulatedDevice::Line::kSerialServer); },
     [] { return SquarePlan(kSamples); },
     0.15},
    {"DeviceByTcp",
     [] { return MakeDevice(SimulatedDevice::Line::kTcp); },
     [] { return SquarePlan(kSamples); },
     0.15},
};

INSTANTIATE_TEST_SUITE_P(Devices, RigContract, testing::ValuesIn(kDevices), NameOfKind);

}  // namespace
}  // namespace faultlab::hardware
