#include "core/structures/motor_driver/motor_driver.h"

#include "core/structures/motor_parameters.h"

namespace faultlab::core {
namespace {

constexpr auto kDriverParameters =
    WithMotor<1>({"Rs", "ohm", "shunt in series with the motor", PartKind::kResistor},
                 {{
                     {"k", "V/V", "gain of the driver"},
                 }});

/// A driver follows its input within a switching period; the models need a lag above zero.
constexpr double kLagS = 1e-6;

AmplifierResponse DriverResponse(const AmplifierValues& p) {
  return {p[0], 1.0, kLagS};
}

ResponseSlope DriverSlope(const AmplifierValues&, int) {
  return {1.0, 0.0, 0.0};
}

}  // namespace

constexpr Structure kMotorDriver = {
    .name = "motor-driver",
    .title = "Driver of known gain and DC motor",
    .parameters = kDriverParameters,
    .response = DriverResponse,
    .slope = DriverSlope,
    .estimated = EstimatedChannel::kIa,
};

constexpr Structure kMotorBySpeed = {
    .name = "motor-by-speed",
    .title = "Driver of known gain and DC motor, of which the speed alone is measured",
    .parameters = kDriverParameters,
    .response = DriverResponse,
    .slope = DriverSlope,
    .estimated = EstimatedChannel::kSpeed,
};

}  // namespace faultlab::core
