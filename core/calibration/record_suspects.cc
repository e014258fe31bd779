#include "core/calibration/record_suspects.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

constexpr int kRowsLateMost = 12;

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

bool IsRead(const Channel& channel, std::span<const Sample> samples) {
  return std::ranges::any_of(
      samples, [&](const Sample& sample) { return std::isfinite(sample.*channel.reading); });
}

bool Has(const Suspect& suspect, const Channel& channel) {
  if (suspect.channels.empty()) return channel.reading != kUc.reading;
  return std::ranges::find(suspect.channels, channel.reading, &Channel::reading) !=
         suspect.channels.end();
}

std::string NamesOf(const std::vector<const Channel*>& channels) {
  std::string names;
  for (const Channel* each : channels)
    names += (names.empty() ? "" : " and ") + std::string(each->name);
  return names.empty() ? "the readings" : names;
}

std::string FollowsMean(const std::vector<const Channel*>& channels, double rows, double period_s) {
  const bool one = channels.size() == 1;
  return Format("%s %s smoothed: %s a mean of about %.2g ms; record %s unsmoothed",
                NamesOf(channels).c_str(),
                one ? "is" : "are",
                one ? "it follows" : "they follow",
                1e3 * period_s * rows,
                one ? "it" : "them");
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

}  // namespace

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
  const double pulses = bench.pulses_per_revolution;
  all.push_back({{&kN},
                 60.0 / (pulses * gear),
                 0,
                 Multiplied(kN, 60.0 / (pulses * gear)) + ": is it in pulses a second?"});
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

std::vector<std::vector<const Channel*>> GroupsOf(std::span<const Sample> samples) {
  std::vector<std::vector<const Channel*>> groups = {{&kUm}, {&kIa}, {&kN}};
  std::erase_if(groups, [&](const auto& each) { return !AreRead(each, samples); });
  if (groups.size() > 1) groups.emplace_back();  // all of them
  if (groups.size() > 3) groups.push_back({&kIa, &kN});
  return groups;
}

Suspect SmoothedBy(std::vector<const Channel*> channels, double of_new, double period_s) {
  std::string sentence = FollowsMean(channels, (2.0 - of_new) / of_new, period_s);
  return {std::move(channels), 1.0, 0, std::move(sentence), 0.0, of_new};
}

Suspect MeanOf(std::vector<const Channel*> channels, int rows, double period_s) {
  std::string sentence = FollowsMean(channels, rows, period_s);
  return {std::move(channels), 1.0, 0, std::move(sentence), 0.0, 1.0, rows};
}

Suspect TakenBy(double taken_v, bool reads_current) {
  // Without a current nothing tells such a driver from friction.
  const char* const or_friction = reads_current ? "" : ", or is the friction larger than described";
  return {{},
          1.0,
          0,
          Format("it fits when uc is less by %.2g V: does the driver take a constant voltage%s?",
                 taken_v,
                 or_friction),
          taken_v};
}

bool AreRead(const std::vector<const Channel*>& channels, std::span<const Sample> samples) {
  return std::ranges::all_of(channels, [&](const Channel* each) { return IsRead(*each, samples); });
}

std::vector<Sample> Mended(std::span<const Sample> samples, const Suspect& suspect) {
  std::vector<Sample> mended(samples.begin(), samples.end());
  for (const Channel& channel : {kUc, kUm, kIa, kN}) {
    // No mean can be undone when its beginning is unknown. The others are made the same mean: the
    // motor is linear, and does not see the difference.
    if (!Has(suspect, channel)) {
      if (suspect.mean_rows > 1) TakeMean(channel.reading, suspect.mean_rows, mended);
      continue;
    }
    if (suspect.of_new < 1.0) Unsmooth(channel.reading, suspect.of_new, mended);
    for (Sample& sample : mended) sample.*channel.reading *= suspect.factor;
    for (std::size_t k = 0; suspect.rows != 0 && k < mended.size(); ++k) {
      const std::size_t from = k + static_cast<std::size_t>(suspect.rows);  // wraps below 0
      mended[k].*channel.reading = from < samples.size() ? samples[from].*channel.reading : kAbsent;
    }
  }
  for (Sample& sample : mended) {
    if (suspect.taken == 0.0) break;
    sample.uc_v = std::copysign(std::max(0.0, std::abs(sample.uc_v) - suspect.taken), sample.uc_v);
  }
  return mended;
}

}  // namespace faultlab::core
