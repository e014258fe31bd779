#pragma once

#include "core/types/component.h"

namespace faultlab::core {

/// Every constant of amplifier and motor, SI units, with the values of the paper's Table 1.
/// C8 is 47 pF (Table 2); Table 1 prints 48 pF, which no estimate at 10 ms can tell apart.
struct PlantParameters {
  double r1_ohm = 1.0;
  double r5_ohm = 1e3;
  double r9_ohm = 10e3;
  double r10_ohm = 10e3;
  double r12_ohm = 10e3;
  double r14_ohm = 1e3;
  double r15_ohm = 1e3;
  double c8_farad = 47e-12;
  double ra_ohm = 7.41;
  double la_henry = 0.77e-3;
  double ke_v_per_rad_s = 25.5e-3;
  double kt_nm_per_a = 25.5e-3;
  double j_kg_m2 = 1.43e-6;
  double b_nm_per_rad_s = 1.8e-6;

  double Get(Component component) const;
  void Set(Component component, double value);

  /// Re1 = R9 R10 / (R9 + R10).
  double re1_ohm() const { return r9_ohm * r10_ohm / (r9_ohm + r10_ohm); }
  /// Re2 = R12 + R14 + R15.
  double re2_ohm() const { return r12_ohm + r14_ohm + r15_ohm; }
  /// k = Re2 / Re1, the amplifier's DC gain, 2.4 at nominal.
  double gain() const { return re2_ohm() / re1_ohm(); }

  friend bool operator==(const PlantParameters&, const PlantParameters&) = default;
};

inline constexpr double kGearRatio = 3.8;             ///< motor shaft : output shaft
inline constexpr double kSamplePeriodSeconds = 0.01;  ///< T of the paper
inline constexpr double kSampleRateHz = 100.0;

}  // namespace faultlab::core
