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

constexpr auto kSourceParameters =
    WithMotor<1>({"Ro", "ohm", "resistance of the current source", PartKind::kResistor},
                 {{
                     {"k", "A/V", "current for one volt of input"},
                 }});

/// What it lets pass of a change of the motor's voltage or resistance is far below any noise.
constexpr double kSourceOhm = 1e6;

AmplifierResponse SourceResponse(const AmplifierValues& p) {
  return {kSourceOhm * p[0], 1.0, kLagS};
}

ResponseSlope SourceSlope(const AmplifierValues&, int) {
  return {kSourceOhm, 0.0, 0.0};
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

constexpr Structure kCurrentDriver = {
    .name = "current-driver",
    .title = "Amplifier that drives a current, and DC motor",
    .parameters = kSourceParameters,
    .response = SourceResponse,
    .slope = SourceSlope,
    .estimated = EstimatedChannel::kUm,
    .source_ohm = kSourceOhm,
};

}  // namespace faultlab::core
