#include "server/diagnosis_json/isolability_question.h"

#include <utility>

#include "core/calibration/bench_noise.h"
#include "core/calibration/calibrate.h"
#include "core/types/number_text.h"
#include "hardware/bench/benches.h"
#include "server/diagnosis_json/channels_text.h"

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
  const core::Bench& bench = *question.bench;
  const Result<const core::BenchProfile*> profile = hardware::FindProfile(bench, question.profile);
  if (!profile) {
    Error error = profile.error();
    error.code = ErrorCode::kInvalid;
    return error;
  }
  out.rig = {bench.nominal,
             1.0,
             profile.value()->delta_s,
             profile.value()->friction.mc_nm,
             core::McUnitOf(bench)};
  out.noise = core::NoiseOf(*profile.value(), bench.nominal.gear_ratio);
  out.period_s = bench.period_s;
  return core::Done{};
}

}  // namespace

Result<core::Channels> ChannelsOf(const IsolabilityQuestion& question) {
  if (!question.channels.empty()) return ParseChannels(question.channels, *question.bench);
  const bool by_um = question.bench->structure->estimated == core::EstimatedChannel::kUm;
  return by_um ? core::Channels::kUmOnly : core::Channels::kAll;
}

Result<core::IsolabilityOptions> ToOptions(const IsolabilityQuestion& question) {
  core::IsolabilityOptions out;
  out.bench = question.bench;
  TRY_DONE(SetRig(question, out));
  if (question.um_noise_v) {
    const double noise_v = *question.um_noise_v;
    if (!(noise_v >= kUmNoiseMin_v && noise_v <= kUmNoiseMax_v)) {
      return core::Refuse(
          "number_outside",
          "um_noise_v",
          {{"member", "um_noise_v"}, {"lowest", kUmNoiseMin_v}, {"highest", kUmNoiseMax_v}});
    }
    out.noise.um_v = noise_v;
  }
  TRY(out.channels, ChannelsOf(question));
  out.window_samples = question.window_samples;
  const double duration_s = kSettlingSeconds + out.window_samples * out.period_s;
  Result<std::vector<double>> uc = core::Generate(question.excitation, duration_s, out.period_s);
  if (!uc) {
    return Error{uc.error().code,
                 "excitation: " + uc.error().field + ": " + uc.error().message,
                 "excitation"};
  }
  out.uc_v = std::move(uc).value();
  out.faults = question.faults;
  return out;
}

std::string ToText(const IsolabilityQuestion& question) {
  std::string text =
      question.calibration
          ? "rig calibrated " + question.calibration->dated
          : (question.profile.empty() ? question.bench->profiles.front().name : question.profile) +
                " profile";
  const auto channels = ChannelsOf(question);
  const bool um_alone = channels.ok() && channels.value() == core::Channels::kUmOnly;
  text += ", " + question.excitation_name + ", " + (um_alone ? "U_{m} alone" : "all channels") +
          ", " + std::to_string(question.window_samples) + " samples of the fault";
  if (question.um_noise_v) {
    const std::string noise = core::Format(", %.3g mV noise", *question.um_noise_v / kMillivolt);
    text += noise;
  }
  return text;
}

}  // namespace faultlab::server
