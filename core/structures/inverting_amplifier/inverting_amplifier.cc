#include "core/structures/inverting_amplifier/inverting_amplifier.h"

#include "core/structures/motor_parameters.h"

namespace faultlab::core {
namespace {

enum Part : int { kR5, kR9, kR10, kR12, kR14, kR15, kC8 };

constexpr auto kInvertingParameters =
    WithMotor<7>({"R1", "ohm", "resistor in series with the motor", PartKind::kResistor},
                 {{
                     {"R5", "ohm", "resistor in series with C8", PartKind::kResistor},
                     {"R9", "ohm", "input resistor", PartKind::kResistor},
                     {"R10", "ohm", "resistor beside R9", PartKind::kResistor},
                     {"R12", "ohm", "feedback resistor", PartKind::kResistor},
                     {"R14", "ohm", "feedback resistor in series with R12", PartKind::kResistor},
                     {"R15", "ohm", "feedback resistor in series with R12", PartKind::kResistor},
                     {"C8", "farad", "feedback capacitor", PartKind::kCapacitor},
                 }});

struct Values {
  double r5, re1, re2, c8;
};

Values Read(const AmplifierValues& p) {
  return {p[kR5], p[kR9] * p[kR10] / (p[kR9] + p[kR10]), p[kR12] + p[kR14] + p[kR15], p[kC8]};
}

AmplifierResponse InvertingResponse(const AmplifierValues& p) {
  const Values v = Read(p);
  return {v.re2 / v.re1, v.r5 / (v.re2 + v.r5), (v.re2 + v.r5) * v.c8};
}

ResponseSlope InvertingSlope(const AmplifierValues& p, int which) {
  const Values v = Read(p);
  switch (which) {
    case kR5:
      return {0.0, v.c8, v.c8};
    case kR9:  // 1/Re1 = 1/R9 + 1/R10
      return {-v.re2 / (p[kR9] * p[kR9]), 0.0, 0.0};
    case kR10:
      return {-v.re2 / (p[kR10] * p[kR10]), 0.0, 0.0};
    case kC8:
      return {0.0, v.r5, v.r5 + v.re2};
    default:  // R12, R14, R15
      return {1.0 / v.re1, 0.0, v.c8};
  }
}

}  // namespace

constexpr Structure kInvertingAmplifier = {
    .name = "inverting-amplifier",
    .title = "Inverting amplifier, series resistor and DC motor",
    .parameters = kInvertingParameters,
    .response = InvertingResponse,
    .slope = InvertingSlope,
    .estimated = EstimatedChannel::kUm,
};

}  // namespace faultlab::core
