#pragma once

#include <limits>
#include <numbers>

#include "core/types/component.h"
#include "core/types/structure.h"

namespace faultlab::core {

/// How large the signals of a bench get, and where the supply of its amplifier ends. The filter
/// starts from it: a state that nothing is known of is this far from rest, one standard deviation.
struct OperatingRange {
  double input_v = 10.0;  ///< of uc, and of the lag behind it
  double current_a = 2.0;
  double speed_rad_s = 500.0;
  /// 0: Coulomb friction brings the motor to rest where the drive is too weak, and holds it there.
  /// Above 0, the published bench: slower than this, friction is in proportion to the speed.
  double creep_rad_s = 5.0;
  double output_min_v = -std::numeric_limits<double>::infinity();  ///< of Uout
  double output_max_v = std::numeric_limits<double>::infinity();

  friend bool operator==(const OperatingRange&, const OperatingRange&) = default;
};

/// Every constant of one bench's amplifier and motor, SI units.
struct PlantParameters {
  const Structure* structure = nullptr;  ///< defines the meaning of `amplifier`
  double series_ohm = 0.0;               ///< Rs between output terminal and motor (R1 of the paper)
  double ra_ohm = 0.0;
  double la_henry = 0.0;
  double ke_v_per_rad_s = 0.0;
  double kt_nm_per_a = 0.0;
  double j_kg_m2 = 0.0;
  double b_nm_per_rad_s = 0.0;
  AmplifierValues amplifier{};
  double gear_ratio = 1.0;  ///< motor shaft : the shaft whose speed n is
  OperatingRange range;

  /// By place in structure->parameters.
  double Get(int parameter) const;
  void Set(int parameter, double value);
  double Get(Component component) const { return Get(component.info().parameter); }
  /// Contract: value > 0.
  void Set(Component component, double value);

  /// Contract: structure != nullptr.
  AmplifierResponse response() const { return structure->response(amplifier); }
  double gain() const { return response().gain; }

  friend bool operator==(const PlantParameters&, const PlantParameters&) = default;
};

/// rad/s of the motor shaft for one rpm behind the gear.
constexpr double RadPerSecondOfRpm(double gear_ratio) {
  return 2.0 * std::numbers::pi / 60.0 * gear_ratio;
}

}  // namespace faultlab::core
