#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/limits.h"
#include "core/bench/profile.h"
#include "core/bench/publication.h"
#include "core/types/component.h"
#include "core/types/excitation_spec.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {

/// Without a pulse of the encoder for this time, the speed reads as 0.
inline constexpr double kPulseTimeoutS = 0.01;

/// The properties of one measured channel of this class of benches.
struct BenchChannel {
  bool exists = false;
  double noise = 0.0;  ///< standard deviation of one reading, in the channel's unit
  /// Standard deviation of what it reads at zero, in the channel's unit; 0: it has no such error.
  double zero_sd = 0.0;
  /// Standard deviation of its scale, a share: no record shows it, so stated errors cover it.
  double gain_sd = 0.0;
  double min = 0.0;  ///< of its converter; a reading at the end is only a bound
  double max = 0.0;
  double v_per_unit = 1.0;  ///< volts at the converter's terminal for one unit
  double offset_v = 0.0;    ///< at the terminal, of 0
  /// n: the reading at speed w is rounded to steps of w^2 times this, s: an encoder's pulse periods
  /// are counted by a timer. 0: no coarser than `noise` at any speed.
  double step_s = 0.0;
  bool tachometer = false;  ///< n: a voltage, read at any speed
  /// n: pulses counted from one reading to the next. It is the mean speed of that time. Beside
  /// other channels it is shown and recorded, but nothing is estimated from it.
  bool counted = false;

  /// Readings that are values. The last code of a converter of 12 bit or more is outside.
  ReadingRange Inside() const {
    if (!exists) return {};
    const double margin = kEndShare * (max - min);
    return {min + margin, max - margin};
  }
  static constexpr double kEndShare = 5e-4;
};

/// How far a healthy bench of this class may be off its data sheet before anything is measured:
/// standard deviations, relative to the value unless a unit is named.
struct BenchNorm {
  double gain = 0.05;
  double series = 0.05;
  double ra = 0.05;
  double j = 0.05;
  double b = 0.20;
  double ke = 0.03;
  double la = 0.0;                     ///< 0: held at the data sheet
  double lag = 0.0;                    ///< of the amplifier; 0: held at the data sheet
  double mc_nm = 0.33e-3;              ///< Coulomb friction, expected
  double mc_sigma_nm = 0.2e-3;         ///< in Nm
  double friction_noise_nm = 0.02e-3;  ///< rms of the slow part of the friction torque
  double friction_tau_s = 0.5;         ///< its correlation time
  double warming = 0.10;               ///< how far Ra may move during a run; 0: not at all
  /// Motors of this kind have brushes, air and supplies that the model lacks: stated errors cover
  /// what these may do. False: the model is all that there is.
  bool missing_physics = true;
};

/// The description of one class of benches. A plain value; hardware/bench/benches.h keeps the
/// benches in use and never moves them.
struct Bench {
  std::string name;       ///< "paper": a-z, 0-9, -
  std::string title;      ///< for people
  std::string id;         ///< name, "-", 12 hex digits of a SHA-256 of what `text` says
  std::string rig_class;  ///< of the rigs that are built so: "bench"; simulators append "-sim"
  const Structure* structure = nullptr;
  double period_s = 0.01;
  double delta_s = 0.005;       ///< DAC edge of uc(k) to the ADC reading of sample k
  ExcitationSpec excitation;    ///< usual one
  std::string excitation_text;  ///< the same as core/signals/excitation_text.h reads it
  double input_min_v = 0.0;     ///< of uc
  double input_max_v = 10.0;
  PlantParameters nominal;           ///< data sheet
  std::vector<ComponentInfo> parts;  ///< the dictionary of faults
  BenchChannel uc;                   ///< the output: scaling alone
  BenchChannel um;
  BenchChannel ua;
  BenchChannel ia;
  BenchChannel n;
  int pulses_per_revolution = 1000;  ///< of the encoder, on the motor shaft
  BenchLimits limits;
  bool limits_stated = false;  ///< a rig that drives a motor needs them
  BenchNorm norm;
  /// Fits follow how the noise of the predictions changes with the parameters. False: the published
  /// bench, whose digits are of fits that did not.
  bool fits_follow_noise = true;
  std::vector<BenchProfile> profiles;  ///< what simulators of it can be, the usual one first
  Publication published;               ///< to compare with
  double usual_speed_rad_s = 0.0;      ///< no load, under the largest input of `excitation`
  std::string text;                    ///< the description as it was read

  int component_count() const { return static_cast<int>(parts.size()); }
  Component component(int index) const { return Component(parts[static_cast<std::size_t>(index)]); }
  std::vector<Component> components() const;
  /// nullopt if the bench has no component with this symbol.
  std::optional<Component> Find(std::string_view symbol) const;
  /// nullptr if the bench has no profile with this name.
  const BenchProfile* FindProfile(std::string_view profile) const;
  /// The input can turn the motor both ways.
  bool reverses() const { return input_min_v < 0.0 && input_max_v > 0.0; }
  /// Motor shaft, rad/s: where the motor passes through rest, a slower speed is not read well, as
  /// it is timed by few pulses or none. 0 where it turns one way, or where pulses are not timed.
  double SpeedFloor() const;
  /// The speed is all that is measured, and each reading of it is a mean.
  bool reads_means() const;
  /// A mean over a period is as good as the speed at its middle (off by (T/tau)^2 / 24 of a
  /// transient, 0.1 % at 70 ms, and by delta^2 / 2T of a change of slope), which the input of the
  /// row before has set where a reading comes soon after the edge of its own.
  bool follows_row_before() const { return reads_means() && delta_s < 0.5 * period_s; }
  /// From the edge of the input that a reading follows to the moment that it is of, s.
  /// @param sampled_s  from the edge of the row's own input to the reading
  double ReadingDelay(double sampled_s, double period) const;
  /// n may be used by estimates.
  bool estimates_use_n() const { return n.exists && (!n.counted || reads_means()); }
  ReadingRules readings() const;
};

}  // namespace faultlab::core
