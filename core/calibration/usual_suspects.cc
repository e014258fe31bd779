#include "core/calibration/usual_suspects.h"

#include <algorithm>
#include <cmath>
#include <iterator>
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
// Of a suspect with a number of its own: it must leave less than this share.
constexpr double kTunedShare = 0.5;
constexpr int kTunedSections = 12;
constexpr int kRowsLateMost = 6;
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
  std::vector<const Channel*> channels;  ///< by rows one, or none: all readings
  double factor = 1.0;
  int rows = 0;  ///< so much later than it should be
  std::string sentence;
  double taken = 0.0;   ///< of uc, whatever it is
  double of_new = 1.0;  ///< y += of_new * (reading - y) has smoothed it
  int mean_rows = 1;    ///< it is a mean of the last so many
};

std::string Multiplied(const Channel& channel, double factor) {
  return Format("it fits when %s is multiplied by %.4g", channel.name, factor);
}

Suspect Unit(const Channel& channel, double factor, const char* unit) {
  return {{&channel},
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
      all.push_back({{&kN},
                     factor,
                     0,
                     Multiplied(kN, factor) + ": is it read on the other side of the gear?"});
    }
    all.push_back(
        {{&kN},
         kRpm / gear,
         0,
         Multiplied(kN, kRpm / gear) + ": is it in rad/s, on the other side of the gear?"});
  }
  for (const Channel* channel : {&kUc, &kUm, &kIa, &kN}) {
    all.push_back(
        {{channel}, -1.0, 0, std::string("it fits with the other sign of ") + channel->name});
  }
  all.push_back({{&kIa, &kN},
                 -1.0,
                 0,
                 "it fits with the other sign of ia and n: is the motor wired the other way?"});
  for (int rows = 2; rows <= kRowsLateMost; ++rows) {
    all.push_back({{},
                   1.0,
                   rows,
                   Format("it fits when the readings are moved %d rows up: they come so much later "
                          "than the uc of their row",
                          rows)});
  }
  for (int rows = 1; rows <= kRowsLateMost; ++rows) {
    for (const Channel* channel : {&kIa, &kN}) {
      all.push_back({{channel},
                     1.0,
                     rows,
                     Format("it fits when %s is moved %d %s up: it comes so much later than the "
                            "others",
                            channel->name,
                            rows,
                            rows == 1 ? "row" : "rows")});
    }
  }
  // Of a count the description says which uc it follows.
  all.push_back(
      {{},
       1.0,
       1,
       bench.reads_means() && !bench.follows_row_before()
           ? "it fits when delta_s is below half a period: is uc put out before the "
             "pulses are read?"
           : "it fits when the readings are moved one row up, to the uc that they follow"});
  all.push_back({{},
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

void Unsmooth(double Sample::*reading, double of_new, std::vector<Sample>& samples) {
  double before = kAbsent;
  for (Sample& sample : samples) {
    const double smoothed = sample.*reading;
    sample.*reading = (smoothed - (1.0 - of_new) * before) / of_new;
    before = smoothed;
  }
}

/// A mean of the last readings, of those that there are.
void TakeMean(double Sample::*reading, int rows, std::vector<Sample>& samples) {
  const std::vector<Sample> as_they_are = samples;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::size_t from = k + 1 - std::min<std::size_t>(k + 1, static_cast<std::size_t>(rows));
    double sum = 0.0;
    for (std::size_t i = from; i <= k; ++i) sum += as_they_are[i].*reading;
    samples[k].*reading = sum / static_cast<double>(k + 1 - from);
  }
}

std::vector<Sample> Mended(std::span<const Sample> samples, const Suspect& suspect) {
  std::vector<Sample> mended(samples.begin(), samples.end());
  // No mean can be undone when its beginning is unknown. The others are made the same mean: the
  // motor is linear, and does not see the difference.
  for (const Channel& channel : {kUc, kUm, kIa, kN}) {
    if (suspect.mean_rows == 1 || channel.reading == suspect.channels.front()->reading) continue;
    TakeMean(channel.reading, suspect.mean_rows, mended);
  }
  if (suspect.of_new < 1.0) Unsmooth(suspect.channels.front()->reading, suspect.of_new, mended);
  for (Sample& sample : mended) {
    if (suspect.taken > 0.0) {
      sample.uc_v =
          std::copysign(std::max(0.0, std::abs(sample.uc_v) - suspect.taken), sample.uc_v);
    }
    for (const Channel* channel : suspect.channels) sample.*channel->reading *= suspect.factor;
  }
  for (std::size_t k = 0; suspect.rows != 0 && k < mended.size(); ++k) {
    const std::size_t from = k + static_cast<std::size_t>(suspect.rows);  // wraps below 0
    for (const Channel& channel : {kUm, kIa, kN}) {
      const bool moves =
          suspect.channels.empty() || channel.reading == suspect.channels.front()->reading;
      if (!moves) continue;
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

std::string FollowsMean(const Channel& channel, double rows, const CalibrationOptions& options) {
  return Format("%s is smoothed: it follows a mean of about %.2g ms; record it unsmoothed",
                channel.name,
                1e3 * options.period_s * rows);
}

/// "ia is smoothed": as by y += a (x - y), in the program that recorded it.
Mending Smoothed(const Channel& channel,
                 std::span<const Sample> tried,
                 const CalibrationOptions& options) {
  const auto suspect_of = [&](double of_new) {
    const double rows = (2.0 - of_new) / of_new;
    return Suspect{{&channel}, 1.0, 0, FollowsMean(channel, rows, options), 0.0, of_new};
  };
  return Tuned(suspect_of, kOfNewLeast, 1.0, tried, options);
}

/// The same as a mean of the last readings: the number of them for which least is left.
Mending Averaged(const Channel& channel,
                 std::span<const Sample> tried,
                 const CalibrationOptions& options) {
  Mending best{{}, std::numeric_limits<double>::infinity()};
  for (int rows = 2; rows <= kMeanRowsMost; ++rows) {
    Suspect suspect{{&channel}, 1.0, 0, FollowsMean(channel, rows, options), 0.0, 1.0, rows};
    const double misfit = MisfitOf(Mended(tried, suspect), options);
    if (misfit < best.misfit) best = {std::move(suspect), misfit};
  }
  return best;
}

/// A bridge of bipolar transistors takes a constant voltage of what it is told.
Mending Taken(std::span<const Sample> tried, const CalibrationOptions& options) {
  double most = 0.0;
  for (const Sample& sample : tried) most = std::max(most, std::abs(sample.uc_v));
  // Without a current nothing tells such a driver from friction.
  const char* const why = IsRead(kIa, tried) ? "" : ", or is the friction larger than described";
  const auto suspect_of = [why](double taken_v) {
    const std::string sentence =
        Format("it fits when uc is less by %.2g V: does the driver take a constant voltage%s?",
               taken_v,
               why);
    return Suspect{{}, 1.0, 0, sentence, taken_v};
  };
  return Tuned(suspect_of, 0.0, 0.9 * most, tried, options);
}

/// Those that leave less than the record as it is, the best first; at most so many.
std::vector<Mending> Likeliest(std::vector<Suspect> suspects,
                               double as_it_is,
                               std::size_t most,
                               std::span<const Sample> tried,
                               const CalibrationOptions& options) {
  std::vector<Mending> mendings;
  const auto is_read = [&](const Channel* channel) { return IsRead(*channel, tried); };
  for (Suspect& each : suspects) {
    if (!std::ranges::all_of(each.channels, is_read)) continue;
    const bool alone = each.rows != 0 && !each.channels.empty();
    if (alone && !(IsRead(kIa, tried) && IsRead(kN, tried))) continue;  // all readings are late
    const double misfit = MisfitOf(Mended(tried, each), options);
    if (misfit < as_it_is) mendings.push_back({std::move(each), misfit});
  }
  std::ranges::sort(mendings, {}, &Mending::misfit);
  mendings.resize(std::min(most, mendings.size()));
  return mendings;
}

/// What has a number that can be chosen must leave much less.
std::vector<Mending> LikeliestTuned(double as_it_is,
                                    std::span<const Sample> tried,
                                    const CalibrationOptions& options) {
  std::vector<Mending> all;
  if (as_it_is < kFits) return all;  // a motor that stands still leaves nothing to explain
  for (const Channel* channel : {&kUm, &kIa, &kN}) {
    if (!IsRead(*channel, tried)) continue;
    all.push_back(Smoothed(*channel, tried, options));
    all.push_back(Averaged(*channel, tried, options));
  }
  all.push_back(Taken(tried, options));
  std::erase_if(all, [&](const Mending& each) {
    return each.misfit > kTunedShare * as_it_is ||
           (each.suspect.taken == 0.0 && each.suspect.mean_rows == 1 &&
            each.suspect.of_new > kOfNewMost);
  });
  std::ranges::sort(all, {}, &Mending::misfit);
  all.resize(std::min<std::size_t>(1, all.size()));
  return all;
}

}  // namespace

std::optional<std::string> UsualSuspect(
    std::span<const Sample> samples,
    const CalibrationOptions& options,
    const std::function<Result<Calibration>(std::span<const Sample>)>& calibrate) {
  const std::span<const Sample> tried = BeginningOf(samples, options.period_s);
  const double as_it_is = MisfitOf(tried, options);
  std::vector<Mending> likeliest =
      Likeliest(SuspectsOf(*options.bench), as_it_is, kTriedSuspects, tried, options);
  std::ranges::move(LikeliestTuned(as_it_is, tried, options), std::back_inserter(likeliest));
  std::ranges::stable_sort(likeliest, {}, &Mending::misfit);
  for (Mending& each : likeliest) {
    if (calibrate(Mended(tried, each.suspect)).ok()) return std::move(each.suspect.sentence);
  }
  // What a mean leaves is not white, as a calibration wants it, and more where the motor stops.
  double of_others = std::numeric_limits<double>::infinity();
  for (const Mending& each : likeliest) {
    if (each.suspect.mean_rows == 1) of_others = std::min(of_others, each.misfit);
  }
  for (Mending& each : likeliest) {
    const double most = std::min(std::max(kFits, kFitsOf * as_it_is), kFitsOfOthers * of_others);
    if (each.suspect.mean_rows > 1 && each.misfit < most) return std::move(each.suspect.sentence);
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
  for (Mending& each : Likeliest(std::move(absences), as_it_is, kTriedAbsences, tried, options)) {
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
    const Mending mending = Smoothed(*each.channel, tried, options);
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
