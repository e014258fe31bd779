#include "core/calibration/stretch_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "core/calibration/stationarity.h"
#include "core/calibration/switches.h"
#include "core/numerics/statistics.h"
#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

// 1.5 s of the paper's bench: enough for every parameter that um determines within a few percent.
constexpr double kSamplesMin = 150;
// Each switch of the input gives one piece of information about gain and time constant.
constexpr double kSwitchesMin = 8;
// Below it, and below a share of the input's range, a switch is the noise of whoever wrote the
// record.
constexpr double kSwingMin = 0.05;
constexpr double kSwingShareMin = 0.005;
// Readings at the rail are only bounds. With more than a tenth of them too little is left to fit.
constexpr double kClippedShareMax = 0.1;
constexpr double kMissingShareMax = 0.2;
// The prior cost is chi-square with at most 11 degrees of freedom when the rig is within the
// tolerances of its data sheet: 40 is exceeded with probability 4e-5.
constexpr double kPriorCostMax = 40.0;
// In use the channel moves by about a quarter of its range. Noise above this share of the range
// hides every fault of interest.
constexpr double kNoiseShareMax = 0.025;
// Of a counted speed as many times its own noise, if that is more: an encoder of few pulses.
constexpr double kCountingMax = 1.5;
// More than this many times the stated noise is told.
constexpr double kNoiseTold = 5.0;
// Of the variation of a channel whose noise is told: more is left only where nothing is explained.
constexpr double kUnexplainedMax = 0.6;
// A friction torque below zero by more standard errors than this is none.
constexpr double kFrictionSigmas = 3.0;
// Largest of quarters x directions squared normal scores (4 x 8): 1e-6 on a healthy rig, with a
// margin for model errors.
constexpr double kStationarityMax = 45.0;
// Chi-square with three degrees of freedom: 2e-4 on a rig that does not walk, and of those few go
// on in one direction.
constexpr double kDriftMin = 20.0;
// Ratio of a block's energy to the average: chi-square/n of 100 readings has sd 0.14.
constexpr double kBlockEnergyMax = 2.0;

std::string Text(const char* format, double a, double b = 0.0) {
  return Format(format, a, b);
}

/// What the model leaves of the channel from which the structure is estimated, and the end of its
/// range, in the channel's unit.
struct KeyNoise {
  double left;
  double range;
};

KeyNoise KeyNoiseOf(const Bench& bench, const NoiseLevel& noise) {
  switch (bench.structure->estimated) {
    case EstimatedChannel::kUm:
      return {noise.um_v, bench.um.max};
    case EstimatedChannel::kIa:
      return {noise.ia_a, bench.ia.max};
    case EstimatedChannel::kSpeed:
      break;
  }
  const double rpm = 1.0 / RadPerSecondOfRpm(bench.nominal.gear_ratio);
  return {rpm * noise.w_rad_s, std::min(bench.n.max, rpm * bench.usual_speed_rad_s)};
}

constexpr const char* kUseAnother = "use an input that switches, such as a PRBS";

/// What a person can do about a check that failed.
const char* Remedy(std::string_view check) {
  if (check == "length") return "give a longer fault-free stretch";
  if (check == "missing") return "look at its wire and at how the record was made";
  if (check == "excitation") return kUseAnother;
  if (check == "saturation") return "use a smaller input or a wider converter range";
  if (check == "noise")
    return "look for a fault inside the stretch, then at its wire, its shield and its unit";
  if (check == "friction") return "look for an offset of uc or of a sensor";
  if (check == "tolerance") {
    return "choose a stretch without a fault, or correct the rig's data sheet";
  }
  return "choose a stretch without a fault, after the rig has warmed up";
}

constexpr const char* kZeroRemedy =
    "adjust its zero, or give zero_sd of this channel in the description of the bench";

/// "ia0 = 0.1 A, where 0.005 A is usual"
std::string ZeroText(const CalibratedQuantity& zero) {
  return zero.name + Text(" = %.3g ", zero.value) + zero.unit +
         Text(", where %.2g ", zero.prior_sigma) + zero.unit + " is usual";
}

std::optional<Error> Judge(std::vector<CalibrationCheck>& checks,
                           const char* name,
                           std::string sentence,
                           double value,
                           double limit,
                           bool passed,
                           const char* remedy = nullptr) {
  checks.push_back({name, sentence, value, limit, passed});
  if (passed) return std::nullopt;
  return Error{ErrorCode::kInvalid,
               std::string("not calibrated, check '") + name + "' failed: " + std::move(sentence) +
                   "; " + (remedy != nullptr ? remedy : Remedy(name)),
               name};
}

/// How much the readings of a channel vary, one standard deviation.
double VariationOf(std::span<const Observation> stretch, std::size_t channel) {
  std::vector<double> readings;
  for (const Observation& o : stretch) {
    if (((o.mask >> channel) & 1) != 0) readings.push_back(o.y[channel]);
  }
  return StandardDeviation(readings);
}

/// Tells of every channel whose noise is far above what the description states: an amplifier whose
/// supply gives way spoils um while ia still fits, and no other check sees it. Refuses a channel of
/// which the model explains next to nothing: it would be taken for noise.
std::optional<Error> JudgeWhatIsLeft(const Bench& bench,
                                     const NoiseLevel& noise,
                                     std::span<const Observation> stretch,
                                     std::vector<CalibrationCheck>& checks) {
  unsigned mask = 0;
  for (const Observation& o : stretch) mask |= o.mask;
  struct Channel {
    const char* name;
    const char* unit;
    double left;
    double stated;
  };
  const double per_rpm = RadPerSecondOfRpm(bench.nominal.gear_ratio);
  const std::array<Channel, kOutputCount> channels = {
      {{"um", "V", noise.um_v, bench.um.noise},
       {"ia", "A", noise.ia_a, bench.ia.noise},
       {"n", "rpm", noise.w_rad_s / per_rpm, bench.n.noise}}};
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const Channel& channel = channels[c];
    const double most = kNoiseTold * channel.stated;
    if (((mask >> c) & 1U) == 0U || channel.left <= most) continue;
    checks.push_back(
        {std::string("noise of ") + channel.name,
         Text("%.3g ", channel.left) + channel.unit +
             Text(" is left, %.0f times the %.3g ", channel.left / channel.stated, channel.stated) +
             channel.unit + " that the description states",
         channel.left,
         most,
         true});
    const double varies = VariationOf(stretch, c) / (c == 2 ? per_rpm : 1.0);
    const double explained_max = kUnexplainedMax * varies;
    if (channel.left <= explained_max) continue;
    return Judge(checks,
                 "noise",
                 std::string("what the model leaves of ") + channel.name +
                     Text(" is %.3g ", channel.left) + channel.unit +
                     Text(", and it varies by no more than %.3g ", varies) + channel.unit,
                 channel.left,
                 explained_max,
                 false);
  }
  return std::nullopt;
}

/// A rig that warms up (copper's resistance rises by 0.4 % a kelvin), brushes that run in.
bool Walks(const Bench& bench, const Stationarity& found) {
  const Stationarity::Walk walk = found.walk();
  for (std::size_t i = 0; i < walk.size(); ++i) {
    const double most = std::min(ModelError::kWalkMax, kWarmingParts[i].share * bench.norm.warming);
    if (std::abs(walk[i]) > most) return false;
  }
  return found.drift > kDriftMin && found.beyond_walk <= kStationarityMax;
}

/// "Ra changes by +2.3 % from the first quarter of the stretch to the last: score 153, at most 45"
std::string ChangeSentence(const std::vector<CalibratedQuantity>& quantities,
                           const Stationarity& found,
                           bool walks) {
  const auto change_of = [&](Coordinate coordinate, double change) {
    const std::string& name = quantities[static_cast<std::size_t>(coordinate)].name;
    // Far off, the linear response says no more than the way.
    if (std::abs(change) > 1.0) return name + (change > 0.0 ? " grows many times" : " vanishes");
    return name + Text(walks ? " by %+.2g %%" : " changes by %+.2g %%", 100.0 * std::expm1(change));
  };
  const char* from = " from the first quarter of the stretch to the last";
  if (walks) {
    constexpr double kTold = 5e-4;
    std::string what;
    for (std::size_t i = 0; i < kWarmingParts.size(); ++i) {
      if (i > 0 && std::abs(found.walk()[i]) < kTold) continue;
      what += (what.empty() ? "" : ", ") + change_of(kWarmingParts[i].coordinate, found.walk()[i]);
    }
    return what + from +
           ", as a rig that warms up or brushes that run in do: that much of them is no fault";
  }
  std::string what = "the rig changes inside the stretch";
  const auto coordinate = static_cast<Coordinate>(found.coordinate);
  if (found.score > kStationarityMax && coordinate < Coordinate::kMc) {
    what = change_of(coordinate, found.change()) + from;
  }
  return what + Text(": score %.1f, at most %.0f", found.score, kStationarityMax);
}

}  // namespace

std::optional<Error> CheckBefore(const Bench& bench,
                                 std::span<const Observation> stretch,
                                 double period_s,
                                 std::vector<CalibrationCheck>& checks) {
  const EstimatedChannelInfo& key = InfoOf(bench.structure->estimated);
  const double n = static_cast<double>(stretch.size());
  int clipped = 0;
  int read = 0;
  double low = stretch.empty() ? 0.0 : stretch.front().u;
  double high = low;
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    const Observation& o = stretch[k];
    low = std::min(low, o.u);
    high = std::max(high, o.u);
    clipped += o.clipped != 0;
    read += ((o.mask >> key.row) & 1) != 0;
  }
  const double swing = high - low;
  const int switches = SwitchesOf(stretch);
  if (auto refusal = Judge(checks,
                           "length",
                           Text("%.0f samples, at least %.0f are needed", n, kSamplesMin),
                           n,
                           kSamplesMin,
                           n >= kSamplesMin)) {
    return refusal;
  }
  const double missing = 1.0 - read / n;
  if (auto refusal =
          Judge(checks,
                "missing",
                Text("%.0f %% of the ", 100.0 * missing) + std::string(key.name) +
                    Text(" readings are missing, at most %.0f %% may be", 100.0 * kMissingShareMax),
                missing,
                kMissingShareMax,
                missing <= kMissingShareMax)) {
    return refusal;
  }
  const double span_s = n * period_s * kSwitchesMin / std::max(1, switches);
  const std::string slowly =
      (switches > 0
           ? Text("give a longer fault-free stretch (at this pace it takes some %.2g s), or ",
                  span_s)
           : std::string()) +
      kUseAnother;
  if (auto refusal = Judge(
          checks,
          "excitation",
          Text("the input switches %.0f times, at least %.0f are needed", switches, kSwitchesMin),
          switches,
          kSwitchesMin,
          switches >= kSwitchesMin,
          slowly.c_str())) {
    return refusal;
  }
  const double swing_min =
      std::min(kSwingMin, kSwingShareMin * (bench.limits.uc_v_max - bench.limits.uc_v_min));
  if (swing <= swing_min) {
    return Judge(checks,
                 "excitation",
                 Text("the input moves by %.2g V, at least %.2g V are needed", swing, swing_min),
                 swing,
                 swing_min,
                 false);
  }
  const double share = clipped / n;
  return Judge(
      checks,
      "saturation",
      Text("um stands at the converter's rail in %.0f %% of the samples, at most %.0f %% may",
           100.0 * share,
           100.0 * kClippedShareMax),
      share,
      kClippedShareMax,
      share <= kClippedShareMax);
}

std::optional<Error> CheckAfter(const Bench& bench,
                                const RigParameters& rig,
                                const NoiseLevel& noise,
                                double period_s,
                                std::span<const Observation> stretch,
                                double prior_cost,
                                const std::vector<CalibratedQuantity>& quantities,
                                std::size_t coordinates,
                                std::vector<CalibrationCheck>& checks,
                                ModelError& error) {
  const double mc_sigma_nm = quantities[static_cast<std::size_t>(Coordinate::kMc)].sigma;
  const EstimatedChannelInfo& key = InfoOf(bench.structure->estimated);
  const auto [left, range] = KeyNoiseOf(bench, noise);
  const double counting = bench.reads_means() ? kCountingMax * bench.n.noise : 0.0;
  const double left_max = std::max(kNoiseShareMax * range, counting);
  if (auto refusal =
          Judge(checks,
                "noise",
                "what the model leaves of " + std::string(key.name) + Text(" is %.3g ", left) +
                    std::string(key.unit) + Text(", at most %.3g ", left_max) +
                    std::string(key.unit) + " may be left",
                left,
                left_max,
                left <= left_max)) {
    return refusal;
  }
  if (auto refusal = JudgeWhatIsLeft(bench, noise, stretch, checks)) return refusal;
  // A drive with a dead zone, or a sensor that is off at zero, looks like friction below zero.
  const double mc_least_nm = -kFrictionSigmas * mc_sigma_nm;
  if (auto refusal = Judge(checks,
                           "friction",
                           Text("the friction torque comes out as %.3g Nm, at least %.3g Nm may",
                                rig.mc_nm,
                                mc_least_nm),
                           rig.mc_nm,
                           mc_least_nm,
                           rig.mc_nm >= mc_least_nm)) {
    return refusal;
  }
  const CalibratedQuantity* farthest = nullptr;
  double distance = 0.0;
  for (const CalibratedQuantity& q : quantities) {
    const double off =
        q.prior_sigma > 0.0 ? std::abs(q.value - q.prior_value) / q.prior_sigma : 0.0;
    if (off >= distance) {
      distance = off;
      farthest = &q;
    }
  }
  const bool zero = farthest != nullptr && farthest >= quantities.data() + coordinates;
  std::string sentence =
      Text("distance from the data sheet %.1f, at most %.0f; farthest ", prior_cost, kPriorCostMax);
  if (zero) {
    sentence += "is the zero of a channel, " + ZeroText(*farthest);
  } else {
    sentence += farthest != nullptr ? farthest->name : "none";
  }
  if (auto refusal = Judge(checks,
                           "tolerance",
                           std::move(sentence),
                           prior_cost,
                           kPriorCostMax,
                           prior_cost <= kPriorCostMax,
                           zero ? kZeroRemedy : nullptr)) {
    return refusal;
  }

  const Stationarity stationarity =
      StationarityOf(rig, noise, period_s, stretch, coordinates, bench.norm.warming);
  const bool changes = stationarity.score > kStationarityMax;
  const bool walks = Walks(bench, stationarity);
  if (auto refusal = Judge(checks,
                           "stationarity",
                           ChangeSentence(quantities, stationarity, walks),
                           stationarity.score,
                           kStationarityMax,
                           !changes || walks)) {
    return refusal;
  }
  if (walks) error.walk = stationarity.walk();
  return Judge(
      checks,
      "residual",
      Text("a quarter of the stretch has %.2f of the average residual energy, at most %.1f",
           stationarity.energy,
           kBlockEnergyMax),
      stationarity.energy,
      kBlockEnergyMax,
      stationarity.energy <= kBlockEnergyMax);
}

}  // namespace faultlab::core
