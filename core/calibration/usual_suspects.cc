#include "core/calibration/usual_suspects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/types/number_text.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// So many samples tell whether a stretch fits, where its input steps often enough in them.
constexpr std::size_t kTriedSamples = 1500;
constexpr int kTriedSteps = 10;
constexpr std::size_t kTriedMost = 4;  // times as many samples, whatever the input

struct Channel {
  const char* name;
  double Sample::*reading;
};
constexpr Channel kUc = {"uc", &Sample::uc_v};
constexpr Channel kUm = {"um", &Sample::um_v};
constexpr Channel kIa = {"ia", &Sample::ia_a};
constexpr Channel kN = {"n", &Sample::n_rpm};

/// Something that is wrong with a record, and what is done about it.
struct Suspect {
  const Channel* channel = nullptr;  ///< nullptr: all readings, by a row
  double factor = 1.0;
  int rows = 0;  ///< so much later than it should be
  std::string sentence;
};

std::string Multiplied(const Channel& channel, double factor) {
  return Format("it fits when %s is multiplied by %.4g", channel.name, factor);
}

Suspect Unit(const Channel& channel, double factor, const char* unit) {
  return {&channel,
          factor,
          0,
          Multiplied(channel, factor) +
              (unit != nullptr ? std::string(": is its unit ") + unit + "?" : "")};
}

std::vector<Suspect> SuspectsOf(const Bench& bench) {
  constexpr double kRpm = 60.0 / (2.0 * 3.14159265358979323846);
  std::vector<Suspect> all = {Unit(kUc, 1e-3, "mV"),
                              Unit(kUm, 1e-3, "mV"),
                              Unit(kIa, 1e-3, "mA"),
                              Unit(kUc, 1e3, nullptr),
                              Unit(kUm, 1e3, nullptr),
                              Unit(kIa, 1e3, nullptr),
                              Unit(kN, kRpm, "rad/s"),
                              Unit(kN, 60.0, "rev/s"),
                              Unit(kN, 1.0 / 6.0, "deg/s"),
                              Unit(kN, 1.0 / kRpm, nullptr)};
  const double gear = bench.nominal.gear_ratio;
  if (gear != 1.0) {
    for (const double factor : {gear, 1.0 / gear}) {
      all.push_back(
          {&kN, factor, 0, Multiplied(kN, factor) + ": is it read on the other side of the gear?"});
    }
    all.push_back(
        {&kN,
         kRpm / gear,
         0,
         Multiplied(kN, kRpm / gear) + ": is it in rad/s, on the other side of the gear?"});
  }
  for (const Channel* channel : {&kUc, &kUm, &kIa, &kN}) {
    all.push_back(
        {channel, -1.0, 0, std::string("it fits with the other sign of ") + channel->name});
  }
  // Of a count the description says which uc it follows.
  all.push_back(
      {nullptr,
       1.0,
       1,
       bench.reads_means() && !bench.follows_row_before()
           ? "it fits when delta_s is below half a period: is uc put out before the "
             "pulses are read?"
           : "it fits when the readings are moved one row up, to the uc that they follow"});
  all.push_back({nullptr,
                 1.0,
                 -1,
                 bench.follows_row_before()
                     ? "it fits when delta_s is above half a period: are the pulses read before uc "
                       "is put out?"
                     : "it fits when the readings are moved one row down"});
  return all;
}

bool IsRead(const Channel& channel, std::span<const Sample> samples) {
  return std::any_of(samples.begin(), samples.end(), [&](const Sample& sample) {
    return std::isfinite(sample.*channel.reading);
  });
}

std::vector<Sample> Mended(std::span<const Sample> samples, const Suspect& suspect) {
  std::vector<Sample> mended(samples.begin(), samples.end());
  if (suspect.channel != nullptr) {
    for (Sample& sample : mended) sample.*suspect.channel->reading *= suspect.factor;
    return mended;
  }
  for (std::size_t k = 0; k < mended.size(); ++k) {
    const std::size_t from = k + static_cast<std::size_t>(suspect.rows);  // wraps below 0
    for (const Channel& channel : {kUm, kIa, kN}) {
      mended[k].*channel.reading = from < samples.size() ? samples[from].*channel.reading : kAbsent;
    }
  }
  return mended;
}

/// The beginning of a stretch that is tried.
std::span<const Sample> BeginningOf(std::span<const Sample> samples, double period_s) {
  std::size_t end = std::min(samples.size(), SpanOf(kTriedSamples, period_s));
  const auto [least, most] = std::ranges::minmax(samples, {}, &Sample::uc_v);
  const double step_v = 0.5 * (most.uc_v - least.uc_v);
  int steps = 0;
  const std::size_t longest =
      std::min(samples.size(), kTriedMost * SpanOf(kTriedSamples, period_s));
  for (std::size_t k = 1; k < longest && (k < end || steps < kTriedSteps); ++k) {
    steps += std::abs(samples[k].uc_v - samples[k - 1].uc_v) > step_v;
    end = std::max(end, k + 1);
  }
  return samples.first(end);
}

/// How far a calibrated rig is from its data sheet.
double DistanceOf(const Calibration& calibration) {
  for (const CalibrationCheck& check : calibration.checks) {
    if (check.name == "tolerance") return check.value;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<std::string> UsualSuspect(
    std::span<const Sample> samples,
    const CalibrationOptions& options,
    const std::function<Result<Calibration>(std::span<const Sample>)>& calibrate) {
  const std::span<const Sample> tried = BeginningOf(samples, options.period_s);
  if (tried.size() < samples.size() && calibrate(tried).ok()) {
    return Format("its first %.3g s fit: look for what has changed since",
                  static_cast<double>(tried.size()) * options.period_s);
  }
  // A channel that can do without is to blame only if the stretch fits without it.
  std::vector<const Channel*> blameless;
  const Channel* without = nullptr;
  for (const Channel* channel : {&kUm, &kIa, &kN}) {
    if (without != nullptr || !IsRead(*channel, tried)) continue;
    const Result<Calibration> calibration = calibrate(Mended(tried, {channel, kAbsent, 0, {}}));
    if (calibration.ok()) without = channel;
    if (!calibration.ok() && calibration.error().field != "missing") blameless.push_back(channel);
  }
  std::optional<std::string> found;
  double nearest = std::numeric_limits<double>::infinity();
  for (Suspect& suspect : SuspectsOf(*options.bench)) {
    if (without != nullptr && suspect.channel != without) continue;
    if (std::ranges::find(blameless, suspect.channel) != blameless.end()) continue;
    if (suspect.channel != nullptr && !IsRead(*suspect.channel, tried)) continue;
    const Result<Calibration> calibration = calibrate(Mended(tried, suspect));
    if (!calibration.ok()) continue;
    const double distance = DistanceOf(calibration.value());
    if (distance >= nearest) continue;
    nearest = distance;
    found = std::move(suspect.sentence);
  }
  if (found || without == nullptr) return found;
  return std::string("it fits without ") + without->name + ": look at its wire and at its unit";
}

}  // namespace faultlab::core
