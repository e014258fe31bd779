#include "core/calibration/usual_suspects.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "core/calibration/bench_noise.h"
#include "core/calibration/clean_stretch.h"
#include "core/calibration/record_suspects.h"
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
// A suspect must leave less than this share of what the record leaves: a motor with another part is
// a little nearer to many.
constexpr double kShare = 0.5;
constexpr double kScaledLeast = 0.2;
// Of the highest uc that the bench takes.
constexpr double kRange = 1.05;
constexpr int kTunedSections = 12;
constexpr double kOfNewLeast = 0.05;
// Of a record whose period is shorter than the described delay.
constexpr double kDelayMost = 0.99;
constexpr double kOfNewMost = 0.75;  // above it hardly anything is smoothed
constexpr int kMeanRowsMost = 32;
// Of the stated noise: a record that leaves no more needs no calibration to fit.
constexpr double kFits = 1.5;
constexpr double kFitsOf = 0.05;       // .. or of what the record leaves as it is
constexpr double kFitsOfOthers = 0.2;  // but of what the best other suspect leaves, at most this
// Noise below this share of what is stated is as telling as one above ..
constexpr double kTooQuiet = 0.1;
// .. of a channel that is smoothed so much; what is less may be another delay of the readings ..
constexpr double kOfNewQuiet = 0.5;
// .. if it is as stated without the smoothing, within this factor.
constexpr double kAsStated = 0.6;

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
  const RigParameters data_sheet{
      options.data_sheet,
      1.0,
      std::min(bench.ReadingDelay(bench.delta_s, options.period_s), kDelayMost * options.period_s),
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

/// The number for which least is left, of a suspect that has one.
Mending Tuned(const std::function<Suspect(double)>& suspect_of,
              double least,
              double most,
              std::span<const Sample> tried,
              const CalibrationOptions& options) {
  const auto misfit_of = [&](double at) {
    return MisfitOf(Mended(tried, suspect_of(at)), options);
  };
  constexpr double kGolden = 0.6180339887498949;
  for (int section = 0; section < kTunedSections; ++section) {
    const double lower = most - kGolden * (most - least);
    const double upper = least + kGolden * (most - least);
    const bool is_lower = misfit_of(lower) < misfit_of(upper);
    (is_lower ? most : least) = is_lower ? upper : lower;
  }
  const double at = 0.5 * (least + most);
  return {suspect_of(at), misfit_of(at)};
}

/// "ia is smoothed".
Mending Smoothed(const std::vector<const Channel*>& channels,
                 std::span<const Sample> tried,
                 const CalibrationOptions& options) {
  const auto suspect_of = [&](double of_new) {
    return SmoothedBy(channels, of_new, options.period_s);
  };
  return Tuned(suspect_of, kOfNewLeast, 1.0, tried, options);
}

/// The same as a mean of the last readings: the number of them for which least is left.
Mending Averaged(const std::vector<const Channel*>& channels,
                 std::span<const Sample> tried,
                 const CalibrationOptions& options) {
  Mending best{{}, std::numeric_limits<double>::infinity()};
  for (int rows = 2; rows <= kMeanRowsMost; ++rows) {
    Suspect suspect = MeanOf(channels, rows, options.period_s);
    const double misfit = MisfitOf(Mended(tried, suspect), options);
    if (misfit < best.misfit) best = {std::move(suspect), misfit};
  }
  return best;
}

Mending Taken(std::span<const Sample> tried, const CalibrationOptions& options) {
  double most = 0.0;
  for (const Sample& sample : tried) most = std::max(most, std::abs(sample.uc_v));
  const bool reads_current = AreRead({&kIa}, tried);
  Mending taken = Tuned(
      [&](double volts) { return TakenBy(volts, reads_current); }, 0.0, 0.9 * most, tried, options);
  // From two levels, of which one is 0, nobody tells it from a smaller gain, which is a part.
  const auto scaled = [](double factor) { return Suspect{{&kUc}, factor, 0, {}}; };
  const Mending smaller = Tuned(scaled, kScaledLeast, 1.0, tried, options);
  if (taken.misfit > kShare * smaller.misfit)
    taken.misfit = std::numeric_limits<double>::infinity();
  return taken;
}

/// No rig was told a uc beyond its range: there its model stands at its end, whatever it is told.
bool LeavesTheRange(const Suspect& suspect, std::span<const Sample> tried, const Bench& bench) {
  const bool larger = suspect.factor > 1.0 && !suspect.channels.empty() &&
                      suspect.channels.front()->reading == kUc.reading;
  return larger && std::ranges::any_of(tried, [&](const Sample& sample) {
           return std::abs(sample.uc_v) * suspect.factor > kRange * bench.limits.uc_v_max;
         });
}

/// Those that leave less than `most`, the best first; at most `number`.
std::vector<Mending> Likeliest(std::vector<Suspect> suspects,
                               double most,
                               std::size_t number,
                               std::span<const Sample> tried,
                               const CalibrationOptions& options) {
  std::vector<Mending> mendings;
  for (Suspect& each : suspects) {
    if (!AreRead(each.channels, tried)) continue;
    const bool alone = each.rows != 0 && !each.channels.empty();
    if (alone && !AreRead({&kIa, &kN}, tried)) continue;  // all readings are late
    if (LeavesTheRange(each, tried, *options.bench)) continue;
    const double misfit = MisfitOf(Mended(tried, each), options);
    if (misfit < most) mendings.push_back({std::move(each), misfit});
  }
  std::ranges::sort(mendings, {}, &Mending::misfit);
  mendings.resize(std::min(number, mendings.size()));
  return mendings;
}

bool IsMean(const Mending& each) {
  return each.suspect.mean_rows > 1;
}

/// What has a number that can be chosen must leave much less. The best mean, and the best other.
std::vector<Mending> LikeliestTuned(double as_it_is,
                                    std::span<const Sample> tried,
                                    const CalibrationOptions& options) {
  if (as_it_is < kFits) return {};  // a motor that stands still leaves nothing to explain
  std::vector<Mending> all;
  for (const std::vector<const Channel*>& channels : GroupsOf(tried)) {
    Mending smoothed = Smoothed(channels, tried, options);
    if (smoothed.suspect.of_new <= kOfNewMost) all.push_back(std::move(smoothed));
    all.push_back(Averaged(channels, tried, options));
  }
  all.push_back(Taken(tried, options));
  std::erase_if(all, [&](const Mending& each) { return each.misfit > kShare * as_it_is; });
  std::ranges::sort(all, {}, &Mending::misfit);
  std::vector<Mending> best;
  for (Mending& each : all) {
    const bool first = std::ranges::none_of(
        best, [&](const Mending& other) { return IsMean(other) == IsMean(each); });
    if (first) best.push_back(std::move(each));
  }
  return best;
}

/// Of the best others; infinite where there is none.
double LeftByOthers(const std::vector<Mending>& all) {
  double left = std::numeric_limits<double>::infinity();
  for (const Mending& each : all) {
    if (!IsMean(each)) left = std::min(left, each.misfit);
  }
  return left;
}

}  // namespace

std::optional<std::string> UsualSuspect(
    std::span<const Sample> samples,
    const CalibrationOptions& options,
    const std::function<Result<Calibration>(std::span<const Sample>)>& calibrate) {
  const std::span<const Sample> tried = BeginningOf(samples, options.period_s);
  const double as_it_is = MisfitOf(tried, options);
  std::vector<Mending> likeliest =
      Likeliest(SuspectsOf(*options.bench), kShare * as_it_is, kTriedSuspects, tried, options);
  std::ranges::move(LikeliestTuned(as_it_is, tried, options), std::back_inserter(likeliest));
  std::ranges::stable_sort(likeliest, {}, &Mending::misfit);
  // What a mean leaves is not white, as a calibration wants it, and more where the motor stops.
  const double mean_most =
      std::min(std::max(kFits, kFitsOf * as_it_is), kFitsOfOthers * LeftByOthers(likeliest));
  for (Mending& each : likeliest) {
    const bool fits =
        IsMean(each) ? each.misfit < mean_most : calibrate(Mended(tried, each.suspect)).ok();
    if (fits) return std::move(each.suspect.sentence);
  }
  if (tried.size() < samples.size() && calibrate(tried).ok()) {
    return Format("its first %.3g s fit: look for what has changed since",
                  static_cast<double>(tried.size()) * options.period_s);
  }
  std::vector<Suspect> absences;
  for (const Channel* channel : {&kUm, &kIa, &kN}) {
    absences.push_back(
        {{channel},
         kAbsent,
         0,
         std::string("it fits without ") + channel->name + ": look at its wire and at its unit"});
  }
  // Without a channel little is told, so little must be left.
  const double absent_most = std::max(kFits, kFitsOf * as_it_is);
  for (Mending& each :
       Likeliest(std::move(absences), absent_most, kTriedAbsences, tried, options)) {
    if (calibrate(Mended(tried, each.suspect)).ok()) return std::move(each.suspect.sentence);
  }
  return std::nullopt;
}

std::optional<std::string> SmoothedChannel(
    std::span<const Sample> samples,
    const CalibrationOptions& options,
    const Calibration& as_it_is,
    const std::function<Result<Calibration>(std::span<const Sample>)>& calibrate) {
  struct Noise {
    const Channel* channel;
    bool used;
    double stated;
    double Calibration::*left;
  };
  const Bench& bench = *options.bench;
  for (const Noise& each :
       {Noise{&kUm, as_it_is.used_um, bench.um.noise, &Calibration::um_noise_v},
        Noise{&kIa, as_it_is.used_ia, bench.ia.noise, &Calibration::ia_noise_a},
        Noise{&kN, as_it_is.used_n, bench.n.noise, &Calibration::n_noise_rpm}}) {
    if (!each.used || as_it_is.*each.left > kTooQuiet * each.stated) continue;
    const std::span<const Sample> tried = BeginningOf(samples, options.period_s);
    const Mending mending = Smoothed({each.channel}, tried, options);
    if (mending.suspect.of_new > kOfNewQuiet) continue;
    const Result<Calibration> mended = calibrate(Mended(tried, mending.suspect));
    const double left = mended.ok() ? mended.value().*each.left : 0.0;
    if (left > kAsStated * each.stated && left < each.stated / kAsStated) {
      return mending.suspect.sentence;
    }
  }
  return std::nullopt;
}

}  // namespace faultlab::core
