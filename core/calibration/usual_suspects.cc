#include "core/calibration/usual_suspects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/calibration/bench_noise.h"
#include "core/calibration/clean_stretch.h"
#include "core/filter/innovation_filter.h"
#include "core/filter/prediction_model.h"
#include "core/types/number_text.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// So many samples tell whether a stretch fits, where its input steps often enough in them.
constexpr std::size_t kTriedSamples = 1500;
constexpr int kTriedSteps = 10;
constexpr std::size_t kTriedMost = 4;  // times as many samples, whatever the input
// Of those that leave less than the record as it is, so many are tried, the best first.
constexpr std::size_t kTriedSuspects = 2;
constexpr std::size_t kTriedAbsences = 2;

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

/// What the data sheet leaves of a record: of each reading, in variances of the stated noise.
double MisfitOf(std::span<const Sample> samples, const CalibrationOptions& options) {
  const Bench& bench = *options.bench;
  const RigParameters data_sheet{options.data_sheet,
                                 1.0,
                                 bench.ReadingDelay(bench.delta_s, options.period_s),
                                 bench.norm.mc_nm,
                                 McUnitOf(bench)};
  const InnovationSummary left =
      RunInnovations(MakePredictionModel(data_sheet, NoiseOf(bench), options.period_s),
                     ReadingsOf(samples, options).observations);
  return left.count > 0 ? left.chi2 / left.count : std::numeric_limits<double>::infinity();
}

/// A record as it would be without what is suspected of it.
struct Mending {
  Suspect suspect;
  double misfit = 0.0;
};

/// Those that leave less than the record as it is, the best first; at most so many.
std::vector<Mending> Likeliest(std::vector<Suspect> suspects,
                               double as_it_is,
                               std::size_t most,
                               std::span<const Sample> tried,
                               const CalibrationOptions& options) {
  std::vector<Mending> mendings;
  for (Suspect& each : suspects) {
    if (each.channel != nullptr && !IsRead(*each.channel, tried)) continue;
    const double misfit = MisfitOf(Mended(tried, each), options);
    if (misfit < as_it_is) mendings.push_back({std::move(each), misfit});
  }
  std::ranges::sort(mendings, {}, &Mending::misfit);
  mendings.resize(std::min(most, mendings.size()));
  return mendings;
}

}  // namespace

std::optional<std::string> UsualSuspect(
    std::span<const Sample> samples,
    const CalibrationOptions& options,
    const std::function<Result<Calibration>(std::span<const Sample>)>& calibrate) {
  const std::span<const Sample> tried = BeginningOf(samples, options.period_s);
  const double as_it_is = MisfitOf(tried, options);
  for (Mending& each :
       Likeliest(SuspectsOf(*options.bench), as_it_is, kTriedSuspects, tried, options)) {
    if (calibrate(Mended(tried, each.suspect)).ok()) return std::move(each.suspect.sentence);
  }
  if (tried.size() < samples.size() && calibrate(tried).ok()) {
    return Format("its first %.3g s fit: look for what has changed since",
                  static_cast<double>(tried.size()) * options.period_s);
  }
  std::vector<Suspect> absences;
  for (const Channel* channel : {&kUm, &kIa, &kN}) {
    absences.push_back(
        {channel,
         kAbsent,
         0,
         std::string("it fits without ") + channel->name + ": look at its wire and at its unit"});
  }
  for (Mending& each : Likeliest(std::move(absences), as_it_is, kTriedAbsences, tried, options)) {
    if (calibrate(Mended(tried, each.suspect)).ok()) return std::move(each.suspect.sentence);
  }
  return std::nullopt;
}

}  // namespace faultlab::core
