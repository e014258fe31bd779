#include "core/signals/excitation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>

#include "core/signals/random.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;
// A step time that equals a sample time up to rounding of k * period belongs to that sample.
constexpr double kTimeSlack = 1e-9;
constexpr int kMultisineLinesMax = 500;

Status CheckLevels(double offset_v, double amplitude_v) {
  if (!std::isfinite(offset_v)) {
    return Refuse("voltage_not_a_number", "offset_v");
  }
  if (!(std::isfinite(amplitude_v) && amplitude_v > 0.0)) {
    return Refuse("amplitude_not_positive", "amplitude_v");
  }
  return Done{};
}

}  // namespace

std::string_view Name(const ExcitationSpec& spec) {
  constexpr std::array<std::string_view, std::variant_size_v<ExcitationSpec>> kNames = {
      "prbs", "step", "multisine", "chirp", "samples"};
  return kNames[spec.index()];
}

Status Validate(const StepSpec& spec, double duration_s) {
  if (!std::isfinite(spec.low_v)) {
    return Refuse("voltage_not_a_number", "low_v");
  }
  if (!std::isfinite(spec.high_v)) {
    return Refuse("voltage_not_a_number", "high_v");
  }
  if (!(spec.at_s >= 0.0 && spec.at_s < duration_s)) {
    return Refuse("step_outside_run", "at_s");
  }
  return Done{};
}

Status Validate(const MultisineSpec& spec, double period_s) {
  if (const Status levels = CheckLevels(spec.offset_v, spec.amplitude_v); !levels) {
    return levels;
  }
  if (!(std::isfinite(spec.base_period_s) && spec.base_period_s > 0.0)) {
    return Refuse("base_period_not_positive", "base_period_s");
  }
  const double lines_max =
      std::min<double>(kMultisineLinesMax, 0.5 * spec.base_period_s / period_s);
  if (spec.lines < 1 || spec.lines > lines_max) {
    return Refuse("lines_outside", "lines", {{"most", static_cast<int>(lines_max)}});
  }
  return Done{};
}

Status Validate(const ChirpSpec& spec, double period_s) {
  if (const Status levels = CheckLevels(spec.offset_v, spec.amplitude_v); !levels) {
    return levels;
  }
  const double limit_hz = 0.5 / period_s;
  if (!(spec.from_hz >= 0.0 && spec.from_hz <= limit_hz)) {
    return Refuse("from_frequency_outside", "from_hz");
  }
  if (!(spec.to_hz > 0.0 && spec.to_hz <= limit_hz)) {
    return Refuse("to_frequency_outside", "to_hz");
  }
  return Done{};
}

Status Validate(const SamplesSpec& spec) {
  if (spec.uc_v.empty()) {
    return Refuse("voltages_wrong", "uc_v");
  }
  const auto bad = std::find_if_not(
      spec.uc_v.begin(), spec.uc_v.end(), [](double value) { return std::isfinite(value); });
  if (bad != spec.uc_v.end()) {
    return Refuse("voltages_wrong", "uc_v/" + std::to_string(bad - spec.uc_v.begin()));
  }
  return Done{};
}

std::vector<double> MakeStep(const StepSpec& spec, int samples, double period_s) {
  LAB_CHECK(samples >= 0, samples);
  std::vector<double> uc_v(static_cast<std::size_t>(samples));
  for (int k = 0; k < samples; ++k) {
    const bool after = k * period_s >= spec.at_s * (1.0 - kTimeSlack);
    uc_v[static_cast<std::size_t>(k)] = after ? spec.high_v : spec.low_v;
  }
  return uc_v;
}

std::vector<double> MakeMultisine(const MultisineSpec& spec, int samples, double period_s) {
  const Status status = Validate(spec, period_s);
  LAB_CHECK(status.ok() && samples >= 0, samples, status.error().message);
  const auto value_at = [&spec](double t_s) {
    double sum = 0.0;
    for (int h = 1; h <= spec.lines; ++h) {
      const double phase = -std::numbers::pi * h * (h - 1.0) / spec.lines;
      sum += std::cos(kTau * h * t_s / spec.base_period_s + phase);
    }
    return sum;
  };
  const double shift_s = spec.seed == 0 ? 0.0 : Random(spec.seed).Uniform(0.0, spec.base_period_s);
  // The peak of the continuous signal, on a grid of 32 points in the shortest period.
  const int grid = 32 * spec.lines;
  double peak = 0.0;
  for (int i = 0; i < grid; ++i) {
    peak = std::max(peak, std::abs(value_at(spec.base_period_s * i / grid)));
  }
  std::vector<double> uc_v(static_cast<std::size_t>(samples));
  for (int k = 0; k < samples; ++k) {
    const double x = std::clamp(value_at(k * period_s + shift_s) / peak, -1.0, 1.0);
    uc_v[static_cast<std::size_t>(k)] = spec.offset_v + spec.amplitude_v * x;
  }
  return uc_v;
}

std::vector<double> MakeChirp(const ChirpSpec& spec, int samples, double period_s) {
  const Status status = Validate(spec, period_s);
  LAB_CHECK(status.ok() && samples >= 0, samples, status.error().message);
  const double duration_s = samples * period_s;
  std::vector<double> uc_v(static_cast<std::size_t>(samples));
  for (int k = 0; k < samples; ++k) {
    const double t = k * period_s;
    const double cycles = spec.from_hz * t + 0.5 * (spec.to_hz - spec.from_hz) * t * t / duration_s;
    uc_v[static_cast<std::size_t>(k)] = spec.offset_v + spec.amplitude_v * std::sin(kTau * cycles);
  }
  return uc_v;
}

Result<std::vector<double>> Generate(const ExcitationSpec& spec,
                                     double duration_s,
                                     double period_s) {
  if (!(std::isfinite(period_s) && period_s > 0.0)) {
    return Refuse("period_not_positive", "period_s");
  }
  if (const auto* list = std::get_if<SamplesSpec>(&spec)) {
    if (const Status status = Validate(*list); !status) {
      return status.error();
    }
    if (list->uc_v.size() > kExcitationSamplesMax) {
      return Refuse("voltages_length", "uc_v");
    }
    return list->uc_v;
  }
  const double count = std::round(duration_s / period_s);
  if (!(std::isfinite(duration_s) && count >= 1.0)) {
    return Refuse("duration_too_short", "duration_s");
  }
  if (count > kExcitationSamplesMax) {
    return Refuse("duration_too_long", "duration_s");
  }
  const int samples = static_cast<int>(count);
  return std::visit(
      [&](const auto& one) -> Result<std::vector<double>> {
        using Spec = std::decay_t<decltype(one)>;
        if constexpr (std::is_same_v<Spec, StepSpec>) {
          if (const Status status = Validate(one, duration_s); !status) {
            return status.error();
          }
          return MakeStep(one, samples, period_s);
        } else if constexpr (std::is_same_v<Spec, SamplesSpec>) {
          return one.uc_v;
        } else {
          if (const Status status = Validate(one, period_s); !status) {
            return status.error();
          }
          if constexpr (std::is_same_v<Spec, PrbsSpec>) {
            return MakePrbs(one, samples, period_s);
          } else if constexpr (std::is_same_v<Spec, MultisineSpec>) {
            return MakeMultisine(one, samples, period_s);
          } else {
            return MakeChirp(one, samples, period_s);
          }
        }
      },
      spec);
}

}  // namespace faultlab::core
