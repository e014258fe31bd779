#pragma once

#include <array>
#include <span>
#include <string_view>

namespace faultlab::core {

/// The circuit that drives the motor, from its input to its output terminal:
///   Uout / Uc = gain (lead_s s + 1)/(lag_s s + 1),   lead_s = direct lag_s
struct AmplifierResponse {
  double gain = 1.0;    ///< V/V
  double direct = 1.0;  ///< lead_s / lag_s, the share of gain that acts at once, in (0, 1]
  double lag_s = 0.0;   ///< > 0

  double lead_s() const { return direct * lag_s; }
};

/// d(gain, lead_s, lag_s)/d(one parameter).
struct ResponseSlope {
  double gain = 0.0;
  double lead_s = 0.0;
  double lag_s = 0.0;
};

enum class PartKind {
  kResistor,
  kCapacitor,  ///< relays connect it uncharged; below some value it no longer acts
  kOther,
};

struct ParameterInfo {
  std::string_view symbol;   ///< "R9", as in the equations of the structure
  std::string_view unit;     ///< SI: "ohm"
  std::string_view meaning;  ///< for people
  PartKind kind = PartKind::kOther;
};

/// Parameters that every structure has, in this order and before its own: the circuit between the
/// output terminal and the load.
enum MotorParameter : int { kSeries, kRa, kLa, kKe, kKt, kJ, kB };
inline constexpr int kMotorParameters = 7;
/// The number of parameters of its amplifier that a structure may have.
inline constexpr int kAmplifierParametersMax = 8;
using AmplifierValues = std::array<double, kAmplifierParametersMax>;

/// The channel whose first-order model the estimators fit: the one that contains all parameters.
enum class EstimatedChannel { kUm, kIa, kSpeed };

/// One kind of bench. All kinds share one motor and differ in the circuit that drives it:
///   Uout = response(amplifier) Uc
///   La di/dt = Uout - (Ra + Rs) i - Ke w,   J dw/dt = KT i - B w - Mf(w)
///   ua = Uout,   um = Uout - Rs i
/// Rs is the first motor parameter, kSeries. Compiled, so that each model is as fast as a
/// hand-written one; core/structures has one folder for each.
struct Structure {
  std::string_view name;                      ///< "inverting-amplifier"
  std::string_view title;                     ///< for people
  std::span<const ParameterInfo> parameters;  ///< kMotorParameters, then the amplifier's
  AmplifierResponse (*response)(const AmplifierValues& amplifier);
  /// @param which  place among the amplifier's parameters
  ResponseSlope (*slope)(const AmplifierValues& amplifier, int which);
  EstimatedChannel estimated = EstimatedChannel::kUm;
  /// Above 0: the circuit is a current source, an amplifier whose feedback is of the current. The
  /// models have it as a voltage source (of V/V so many times as the source has A/V) behind this
  /// resistance, which is kSeries and far above that of any motor. Then um and ua are the voltage
  /// of the motor, and the supply is no part of the models.
  double source_ohm = 0.0;

  bool drives_current() const { return source_ohm > 0.0; }
  int parameter_count() const { return static_cast<int>(parameters.size()); }
  /// Place of a symbol in `parameters`, -1 when there is none.
  int Find(std::string_view symbol) const {
    for (int i = 0; i < parameter_count(); ++i) {
      if (parameters[static_cast<std::size_t>(i)].symbol == symbol) return i;
    }
    return -1;
  }
};

}  // namespace faultlab::core
