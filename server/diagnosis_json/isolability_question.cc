#include "server/diagnosis_json/isolability_question.h"

#include <array>
#include <cstdio>
#include <utility>

#include "core/plant/profile.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;

/// Samples before the fault, in which the filter settles.
constexpr double kSettlingSeconds = 5.0;
constexpr double kUmNoiseMin_v = 1e-5;  // a converter's step is 0.3 mV
constexpr double kUmNoiseMax_v = 1.0;
constexpr double kMillivolt = 1e-3;

core::Status SetRig(const IsolabilityQuestion& question, core::IsolabilityOptions& out) {
  if (question.calibration) {
    out.rig = core::ParametersOf(*question.calibration);
    out.noise = core::NoiseOf(*question.calibration);
    out.period_s = question.calibration->period_s;
    return core::Done{};
  }
  const Result<core::BenchProfile> profile = core::FindBenchProfile(question.profile);
  if (!profile) {
    return Error{ErrorCode::kInvalid, profile.error().message, "profile"};
  }
  const core::BenchProfile& bench = profile.value();
  out.rig.delta_s = bench.delta_s;
  out.rig.mc_nm = bench.friction.mc_nm;
  out.noise = {bench.noise.um_v,
               bench.noise.ia_a,
               bench.noise.n_rpm * core::kRadPerSecondOfRpm,
               bench.friction.noise_rms_nm,
               bench.friction.noise_tau_s};
  return core::Done{};
}

}  // namespace

Result<core::IsolabilityOptions> ToOptions(const IsolabilityQuestion& question) {
  core::IsolabilityOptions out;
  const core::Status rig = SetRig(question, out);
  if (!rig) {
    return rig.error();
  }
  if (question.um_noise_v) {
    const double noise_v = *question.um_noise_v;
    if (!(noise_v >= kUmNoiseMin_v && noise_v <= kUmNoiseMax_v)) {
      return Error{ErrorCode::kInvalid,
                   "um_noise_v must lie between 0.00001 and 1 (volt, one standard deviation)",
                   "um_noise_v"};
    }
    out.noise.um_v = noise_v;
  }
  if (question.channels != "um" && question.channels != "all") {
    return Error{ErrorCode::kInvalid,
                 "channels '" + question.channels + "': expected um or all",
                 "channels"};
  }
  out.channels = question.channels == "um" ? core::Channels::kUmOnly : core::Channels::kAll;
  out.window_samples = question.window_samples;
  const double duration_s = kSettlingSeconds + out.window_samples * out.period_s;
  Result<std::vector<double>> uc = core::Generate(question.excitation, duration_s, out.period_s);
  if (!uc) {
    return Error{uc.error().code, "excitation: " + uc.error().message, "excitation"};
  }
  out.uc_v = std::move(uc).value();
  out.faults = question.faults;
  return out;
}

std::string ToText(const IsolabilityQuestion& question) {
  std::string text = question.calibration ? "rig calibrated " + question.calibration->dated
                                          : question.profile + " profile";
  text += ", " + question.excitation_name + ", " +
          (question.channels == "um" ? "U_{m} alone" : "all channels") + ", " +
          std::to_string(question.window_samples) + " samples of the fault";
  if (question.um_noise_v) {
    std::array<char, 40> noise;
    std::snprintf(noise.data(), noise.size(), ", %.3g mV noise", *question.um_noise_v / kMillivolt);
    text += noise.data();
  }
  return text;
}

}  // namespace faultlab::server
