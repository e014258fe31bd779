#include "hardware/contact_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/types/check.h"
#include "core/types/number_text.h"
#include "hardware/played_run.h"

namespace faultlab::hardware {
namespace {

/// A window lasts so long, or so many samples on a slower bench.
constexpr double kWindowSeconds = 0.6;
constexpr int kWindowSamplesMin = 60;
/// Of the largest drive of the usual excitation: the levels of the two halves of a window.
constexpr double kLowShare = 2.0 / 3.0;
/// A healthy rig may be off its description by so much of a channel's level.
constexpr double kLevelTolerance = 0.02;
/// The first part of a window is not compared: relays switch and capacitors are charged.
constexpr std::size_t kUnsettledPart = 4;
/// Distances, root mean square over the channels in units of noise and tolerance together.
constexpr int kFrictionSteps = 5;   ///< of half a standard deviation, each way
constexpr double kVisible = 3.0;    ///< two effects that are closer look the same
constexpr double kNear = 1.5;       ///< always near enough
constexpr double kFar = 6.0;        ///< what is farther from every part is none of them
constexpr double kNearShare = 0.5;  ///< of the effect itself: tolerances of several parts add up
constexpr double kNominalShare = 0.25;  ///< of the level, for the nominal windows

struct Channel {
  double core::Sample::*member;
  double noise;
};

struct Switching {
  core::Component component;
  int position;
};

/// What relays change and the bench measures.
std::vector<Channel> ChannelsOf(const core::Bench& bench) {
  std::vector<Channel> channels;
  if (bench.um.exists) channels.push_back({&core::Sample::um_v, bench.um.noise});
  if (bench.ia.exists) channels.push_back({&core::Sample::ia_a, bench.ia.noise});
  if (channels.empty()) channels.push_back({&core::Sample::n_rpm, bench.n.noise});
  return channels;
}

/// All positions but the nominal ones, board by board.
std::vector<Switching> SwitchingsOf(const core::Bench& bench) {
  std::vector<Switching> all;
  for (const core::Component component : bench.components()) {
    const auto count = static_cast<int>(component.info().positions.size());
    for (int position = 1; position < count; ++position) all.push_back({component, position});
  }
  return all;
}

std::size_t WindowSamples(const core::Bench& bench) {
  const auto samples = static_cast<int>(std::lround(kWindowSeconds / bench.period_s));
  const auto rest = static_cast<int>(std::ceil(bench.limits.relay_rest_s / bench.period_s)) + 1;
  return static_cast<std::size_t>(std::max({samples, kWindowSamplesMin, rest}));
}

/// The run: warm-up, then nominal and position in turn, then nominal once more.
std::size_t WindowCount(const core::Bench& bench) {
  return 2 + 2 * SwitchingsOf(bench).size();
}
std::size_t WindowOf(std::size_t switching) {
  return 2 + 2 * switching;
}

std::vector<double> DriveOf(const core::Bench& bench, double high_v) {
  const std::size_t window = WindowSamples(bench);
  std::vector<double> uc_v;
  for (std::size_t k = 0; k < window * WindowCount(bench); ++k) {
    uc_v.push_back(k % window < window / 2 ? kLowShare * high_v : high_v);
  }
  return uc_v;
}

/// Of the plan, with another position in the window of one switching (nominal: none).
std::vector<core::Fault> FaultsOf(const core::Bench& bench, std::size_t changed, int to_position) {
  const double window_s = static_cast<double>(WindowSamples(bench)) * bench.period_s;
  std::vector<core::Fault> faults;
  const std::vector<Switching> switchings = SwitchingsOf(bench);
  for (std::size_t i = 0; i < switchings.size(); ++i) {
    const int position = i == changed ? to_position : switchings[i].position;
    if (position == 0) continue;
    const auto& positions = switchings[i].component.info().positions;
    core::Fault fault;
    fault.component = switchings[i].component;
    fault.value = positions[static_cast<std::size_t>(position)].value;
    fault.at_s = static_cast<double>(WindowOf(i)) * window_s;
    faults.push_back(fault);
    fault.value = positions.front().value;
    fault.at_s += window_s;
    faults.push_back(fault);
  }
  return faults;
}
constexpr std::size_t kUnchanged = std::numeric_limits<std::size_t>::max();

/// What the description makes of a plan: the usual simulator without noise.
/// @param mc_nm  Coulomb friction of this motor
std::vector<core::Sample> Predict(const core::Bench& bench,
                                  double delta_s,
                                  double mc_nm,
                                  std::span<const double> uc_v,
                                  std::span<const core::Fault> faults) {
  core::BenchProfile profile = bench.profiles.front();
  const double breakaway_nm = std::max(profile.friction.ms_nm - profile.friction.mc_nm, 0.0);
  profile.delta_s = delta_s;
  profile.noise = {};
  profile.friction.noise_rms_nm = 0.0;
  profile.friction.mc_nm = mc_nm;
  profile.friction.ms_nm = mc_nm + breakaway_nm;
  return core::SimulateRecord(profile, bench.nominal, uc_v, faults, 1, bench.period_s);
}

/// The samples of a run by their place in the plan; those that are missing are absent.
std::vector<core::Sample> InOrder(std::span<const core::Sample> samples, std::size_t size) {
  std::vector<core::Sample> ordered(size);
  for (const core::Sample& sample : samples) {
    const auto index = static_cast<std::size_t>(sample.index);
    if (sample.index >= 0 && index < size) ordered[index] = sample;
  }
  return ordered;
}

/// Windows of one record, seen through the channels that a bench has.
class Windows {
 public:
  Windows(const core::Bench& bench, std::vector<core::Sample> record)
      : record_(std::move(record)), size_(WindowSamples(bench)) {}

  double At(std::size_t window, std::size_t k, const Channel& channel) const {
    return record_[window * size_ + k].*channel.member;
  }
  /// What a window has more than a nominal one that, as it does, follows a nominal one.
  double Effect(std::size_t window, std::size_t k, const Channel& channel) const {
    return At(window, k, channel) - At(1, k, channel);
  }
  double MeanOfHigh(std::size_t window, double core::Sample::*member) const {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t k = size_ / 2 + size_ / 4; k < size_; ++k) {
      const double value = record_[window * size_ + k].*member;
      if (std::isnan(value)) continue;
      sum += value;
      ++count;
    }
    return count > 0 ? sum / static_cast<double>(count) : core::kAbsent;
  }
  std::size_t size() const { return size_; }

 private:
  std::vector<core::Sample> record_;
  std::size_t size_;
};

class Judge {
 public:
  Judge(const core::Bench& bench,
        double high_v,
        double delta_s,
        std::span<const core::Sample> samples)
      : bench_(bench),
        delta_s_(delta_s),
        uc_v_(DriveOf(bench, high_v)),
        switchings_(SwitchingsOf(bench)),
        channels_(ChannelsOf(bench)),
        seen_(bench, InOrder(samples, uc_v_.size())),
        expected_(Expect(kUnchanged, 0)) {
    FindFriction();
  }

  ContactReport Report() const {
    ContactReport report;
    report.nominal = Nominal();
    report.ok = report.nominal.empty();
    for (std::size_t i = 0; i < switchings_.size(); ++i) {
      report.positions.push_back(Find(i));
      report.ok = report.ok && report.positions.back().contact != Contact::kWrong;
    }
    return report;
  }

 private:
  Windows Expect(std::size_t changed, int to_position) const {
    return {bench_,
            Predict(bench_, delta_s_, mc_nm_, uc_v_, FaultsOf(bench_, changed, to_position))};
  }

  /// Friction is each motor's own and changes um more than some parts do: of the values that the
  /// description expects, the one that explains the first nominal window best.
  void FindFriction() {
    double nearest = std::numeric_limits<double>::infinity();
    Windows best = expected_;
    double best_nm = mc_nm_;
    for (int step = -kFrictionSteps; step <= kFrictionSteps; ++step) {
      mc_nm_ = std::max(0.0, bench_.norm.mc_nm + 0.5 * step * bench_.norm.mc_sigma_nm);
      Windows expected = Expect(kUnchanged, 0);
      const double distance = Distance([&](std::size_t k, const Channel& channel) {
        return seen_.At(1, k, channel) - expected.At(1, k, channel);
      });
      if (distance >= nearest) continue;
      nearest = distance;
      best = std::move(expected);
      best_nm = mc_nm_;
    }
    mc_nm_ = best_nm;
    expected_ = std::move(best);
  }

  /// Level of the nominal windows, as expected: what tolerances are a share of.
  double Level(const Channel& channel) const {
    double square = 0.0;
    for (std::size_t k = 0; k < expected_.size(); ++k) {
      square += std::pow(expected_.At(1, k, channel), 2);
    }
    return std::sqrt(square / static_cast<double>(expected_.size()));
  }

  template <typename Difference>
  double Distance(const Difference& difference) const {
    double square = 0.0;
    double count = 0.0;
    for (const Channel& channel : channels_) {
      const double unit = std::hypot(channel.noise, kLevelTolerance * Level(channel));
      for (std::size_t k = seen_.size() / kUnsettledPart; k < seen_.size(); ++k) {
        const double off = difference(k, channel) / unit;
        if (std::isnan(off)) continue;
        square += off * off;
        count += 1.0;
      }
    }
    return count > 0.0 ? std::sqrt(square / count) : std::numeric_limits<double>::infinity();
  }

  /// Empty, or what is wrong with the first nominal window.
  std::string Nominal() const {
    for (const Channel& channel : channels_) {
      const bool um = channel.member == &core::Sample::um_v;
      if (!um && channels_.size() > 1) continue;  // friction makes more of ia than a wrong part
      const double expected = expected_.MeanOfHigh(1, channel.member);
      const double seen = seen_.MeanOfHigh(1, channel.member);
      if (std::abs(seen - expected) <= kNominalShare * std::abs(expected)) continue;
      return core::Format(
          "with all positions nominal %s is %.3g where %.3g is expected: supply, "
          "amplifier or a nominal part",
          um                                      ? "um"
          : channel.member == &core::Sample::ia_a ? "ia"
                                                  : "n",
          seen,
          expected);
    }
    return {};
  }

  ContactFinding Find(std::size_t switching) const {
    const auto [component, position] = switchings_[switching];
    const auto& positions = component.info().positions;
    const core::SwitchPosition& own = positions[static_cast<std::size_t>(position)];
    const std::size_t window = WindowOf(switching);
    ContactFinding finding;
    finding.component = component;
    finding.value = own.value;
    finding.line = "Do" + std::to_string(own.line);
    if (bench_.um.exists) {
      finding.um_expected_v = expected_.MeanOfHigh(window, &core::Sample::um_v);
      finding.um_seen_v = seen_.MeanOfHigh(window, &core::Sample::um_v);
    }
    if (bench_.ia.exists) {
      finding.ia_expected_a = expected_.MeanOfHigh(window, &core::Sample::ia_a);
      finding.ia_seen_a = seen_.MeanOfHigh(window, &core::Sample::ia_a);
    }

    const auto effect = [&](std::size_t k, const Channel& channel) {
      return expected_.Effect(window, k, channel);
    };
    const double own_size = Distance(effect);
    double nearest = std::numeric_limits<double>::infinity();
    double own_distance = nearest;
    int likest = -1;
    bool looks_the_same = false;  // the nearest as this one
    for (int other = 0; other < static_cast<int>(positions.size()); ++other) {
      const Windows as_other = other == position ? expected_ : Expect(switching, other);
      const double distance = Distance([&](std::size_t k, const Channel& channel) {
        return seen_.Effect(window, k, channel) - as_other.Effect(window, k, channel);
      });
      if (other == position) own_distance = distance;
      if (distance >= nearest) continue;
      nearest = distance;
      likest = other;
      looks_the_same = Distance([&](std::size_t k, const Channel& channel) {
                         return as_other.Effect(window, k, channel) - effect(k, channel);
                       }) < kVisible;
    }
    const bool near = own_distance <= std::max(kNear, kNearShare * own_size);
    if (own_size < kVisible) {
      finding.contact = own_distance <= kVisible ? Contact::kReadBackOnly : Contact::kWrong;
    } else {
      finding.contact = near && looks_the_same ? Contact::kRecognised : Contact::kWrong;
    }
    if (finding.contact == Contact::kWrong) {
      finding.text = Looks(component, likest, position, nearest > kFar);
    }
    return finding;
  }

  /// @param far  it is no part of this board
  static std::string Looks(core::Component component, int likest, int position, bool far) {
    if (likest == 0) return "nothing changes: the relay, its contact or its wire";
    if (likest < 0) return "no samples of it";
    if (likest == position) return "the effect is of another size: measure the part";
    if (far) return "no part of this board does that: an open contact, or a wire of another board";
    const auto& like = component.info().positions[static_cast<std::size_t>(likest)];
    return core::Format("looks like %.6g %s of Do%d: are wires exchanged?",
                        like.value,
                        std::string(core::Unit(component)).c_str(),
                        like.line);
  }

  const core::Bench& bench_;
  const double delta_s_;
  const std::vector<double> uc_v_;
  const std::vector<Switching> switchings_;
  const std::vector<Channel> channels_;
  const Windows seen_;
  double mc_nm_ = bench_.norm.mc_nm;
  Windows expected_;
};

}  // namespace

std::string_view Name(Contact contact) {
  constexpr std::array<std::string_view, 3> kNames = {"recognised", "read_back_only", "wrong"};
  return kNames[static_cast<std::size_t>(contact)];
}

double ContactDrive(const core::Bench& bench) {
  const auto usual = core::Generate(bench.excitation, 300 * bench.period_s, bench.period_s);
  if (!usual || usual.value().empty()) return bench.input_max_v;
  const auto [least, most] = std::minmax_element(usual.value().begin(), usual.value().end());
  return std::abs(*least) > std::abs(*most) ? *least : *most;
}

RunPlan ContactPlan(const core::Bench& bench, double high_v) {
  RunPlan plan;
  plan.period_s = bench.period_s;
  plan.uc_v = DriveOf(bench, high_v);
  plan.faults = FaultsOf(bench, kUnchanged, 0);
  return plan;
}

ContactReport JudgeContacts(std::span<const core::Sample> samples,
                            const core::Bench& bench,
                            double high_v,
                            double delta_s) {
  LAB_CHECK(!bench.profiles.empty(), bench.name);
  return Judge(bench, high_v, delta_s, samples).Report();
}

core::Result<ContactReport> CheckContacts(Rig& rig, Epoch epoch) {
  const RigDescription& about = rig.description();
  const core::Bench& bench = *about.bench;
  // A rig may have closer limits than its class.
  const double high_v = std::clamp(ContactDrive(bench), about.uc_v_min, about.uc_v_max);
  TRY(const auto samples,
      PlayRun(rig, epoch, ContactPlan(bench, high_v), "the check of the contacts"));
  return JudgeContacts(samples, bench, high_v, about.delta_s);
}

}  // namespace faultlab::hardware
