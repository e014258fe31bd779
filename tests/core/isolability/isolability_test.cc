#include "core/isolability/isolability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

IsolabilityOptions BenchOptions(Channels channels = Channels::kUmOnly, int window = 100) {
  IsolabilityOptions options;
  options.bench = &paper::Bench();
  options.rig = paper::Rig();
  options.noise = paper::Noise();
  options.rig.mc_nm = 0.33e-3;
  options.channels = channels;
  options.window_samples = window;
  std::mt19937_64 random(3);
  for (int k = 0; k < 250; ++k) {
    options.uc_v.push_back((random() >> 40) % 2 == 0 ? 2.0 : 3.0);
  }
  return options;
}

const Isolability& Bench() {
  static const Isolability answer = AnalyseIsolability(BenchOptions()).value();
  return answer;
}

const FaultIsolability& Of(const Isolability& answer, Component component, double value) {
  for (const FaultIsolability& judged : answer.faults) {
    if (judged.fault.component == component && judged.fault.value == value) {
      return judged;
    }
  }
  throw std::logic_error("not in the set");
}

TEST(Isolability, FindsByItselfThatR9AndR12AreOneGroup) {
  ASSERT_EQ(Bench().ambiguous.size(), 1u);
  EXPECT_EQ(Bench().ambiguous[0], (std::vector<Component>{paper::kR9, paper::kR12}));
  EXPECT_NEAR(std::abs(Bench().overlap(Index(paper::kR9), Index(paper::kR12))), 1.0, 1e-9);
}

TEST(Isolability, NamesThePublishedTwinsOfTheR9Faults) {
  // R9 33, 56, 100 kohm have exactly the same effect as R12 5818, 5071, 4600 ohm: 12 kohm / (R9 ||
  // 10 kohm).
  for (const auto& [r9, r12] : {std::pair{33e3, 5818.0}, {56e3, 5071.0}, {100e3, 4600.0}}) {
    const FaultIsolability& judged = Of(Bench(), paper::kR9, r9);
    const NearestRival& twin = judged.rival[static_cast<std::size_t>(Index(paper::kR12))];
    EXPECT_NEAR(twin.value, r12, 0.002 * r12);
    EXPECT_LT(twin.kl_nats, 0.05);
    EXPECT_EQ(judged.group, (std::vector<Component>{paper::kR9, paper::kR12}));
  }
}

TEST(Isolability, KnowsThatAGainBelowHalfCanOnlyBeR12) {
  for (double value : {2e3, 3.3e3}) {
    const FaultIsolability& judged = Of(Bench(), paper::kR12, value);
    EXPECT_EQ(judged.group, (std::vector<Component>{paper::kR12})) << value;
  }
  EXPECT_EQ(Of(Bench(), paper::kR12, 5.6e3).group,
            (std::vector<Component>{paper::kR12, paper::kR9}));
}

TEST(Isolability, SeesEveryFaultOfThePaperAndSeparatesAllButTwoPairsByUmAlone) {
  for (const FaultIsolability& judged : Bench().faults) {
    const Component component = judged.fault.component;
    EXPECT_TRUE(judged.visible) << Name(component) << judged.fault.value;
    const bool gain = component == paper::kR9 || component == paper::kR12;
    const bool inertia_gone = component == paper::kJ && judged.fault.value < 1e-7;
    if (!gain && !inertia_gone) {
      EXPECT_EQ(judged.group.size(), 1u) << Name(component) << judged.fault.value;
    }
  }
}

TEST(Isolability, KnowsThatOnlyCurrentAndSpeedTellAMotorWithoutInertiaFromAShortedArmature) {
  // Both reduce J (Ra + R1) / D, the only term with them that um depends on.
  EXPECT_EQ(Of(Bench(), paper::kJ, 1.43e-8).group, (std::vector<Component>{paper::kJ, paper::kRa}));
  const Isolability richer = AnalyseIsolability(BenchOptions(Channels::kAll)).value();
  EXPECT_EQ(Of(richer, paper::kJ, 1.43e-8).group, (std::vector<Component>{paper::kJ}));
}

TEST(Isolability, HasTheBoundsThatWereFoundIndependently) {
  // Cramer-Rao bounds from an independent computation, 100 samples, 15 mV: R12 0.031 %, R9 0.052 %,
  // R1 1.6 %, J 3.1 %, B 10 %. The inputs differ, so the tolerance is a fifth.
  const auto sigma = [](Component component) {
    return Bench().smallest[static_cast<std::size_t>(Index(component))].relative_sigma;
  };
  EXPECT_NEAR(sigma(paper::kR12), 0.00031, 0.2 * 0.00031);
  EXPECT_NEAR(sigma(paper::kR9), 0.00052, 0.2 * 0.00052);
  EXPECT_NEAR(sigma(paper::kR1), 0.016, 0.2 * 0.016);
  EXPECT_NEAR(sigma(paper::kJ), 0.031, 0.2 * 0.031);
  EXPECT_NEAR(sigma(paper::kB), 0.10, 0.2 * 0.10);
}

TEST(Isolability, KnowsThatC8BelowAHundredNanofaradIsInvisible) {
  const SmallestVisible& c8 = Bench().smallest[static_cast<std::size_t>(Index(paper::kC8))];
  ASSERT_TRUE(c8.above.has_value());
  EXPECT_GT(*c8.above, 30e-9);
  EXPECT_LT(*c8.above, 1e-6);
  EXPECT_FALSE(c8.below.has_value());
  EXPECT_GT(c8.relative_sigma, 10.0);
}

TEST(Isolability, SeesSmallerFaultsWithMoreDataAndMoreChannels) {
  const Isolability longer = AnalyseIsolability(BenchOptions(Channels::kUmOnly, 200)).value();
  const Isolability richer = AnalyseIsolability(BenchOptions(Channels::kAll, 100)).value();
  for (Component component : paper::Parts()) {
    const int i = Index(component);
    EXPECT_GE(longer.fisher(i, i), Bench().fisher(i, i) * 0.999) << Name(component);
    EXPECT_GE(richer.fisher(i, i), Bench().fisher(i, i) * 0.999) << Name(component);
  }
}

TEST(Isolability, GivesDistancesWhoseSquareRootGrowsWithTheFault) {
  IsolabilityOptions options = BenchOptions();
  options.faults = {{paper::kRa, 7.41 * 1.01}, {paper::kRa, 7.41 * 1.02}};
  const Isolability answer = AnalyseIsolability(options).value();
  const double ratio = answer.faults[1].kl_nominal_nats / answer.faults[0].kl_nominal_nats;
  EXPECT_NEAR(ratio, 4.0, 0.2);
  // And the quadratic form of the Fisher information: D = 1/2 log(1.01)^2 F.
  const double information = answer.fisher(Index(paper::kRa), Index(paper::kRa));
  EXPECT_NEAR(answer.faults[0].kl_nominal_nats,
              0.5 * std::pow(std::log(1.01), 2) * information,
              0.05 * answer.faults[0].kl_nominal_nats);
}

TEST(Isolability, StatesTheSmallestFaultThatItsOwnDistanceConfirms) {
  for (const SmallestVisible& smallest : Bench().smallest) {
    for (const std::optional<double>& value : {smallest.below, smallest.above}) {
      if (!value.has_value()) {
        continue;
      }
      IsolabilityOptions options = BenchOptions();
      options.faults = {{smallest.component, *value}};
      const double distance = AnalyseIsolability(options).value().faults[0].kl_nominal_nats;
      EXPECT_NEAR(distance, Bench().kl_visible_nats, 0.01 * Bench().kl_visible_nats)
          << Name(smallest.component) << " " << *value;
    }
  }
}

TEST(Isolability, SeesTheGainButNoInertiaUnderAConstantInput) {
  IsolabilityOptions options = BenchOptions();
  options.uc_v.assign(250, 2.5);
  const Isolability answer = AnalyseIsolability(options).value();
  EXPECT_TRUE(Of(answer, paper::kR12, 5.6e3).visible);
  EXPECT_FALSE(Of(answer, paper::kJ, 1.43e-4).visible);
  EXPECT_FALSE(Of(answer, paper::kC8, 1e-6).visible);
}

TEST(Isolability, NamesTheFieldThatItRefuses) {
  const auto field = [](const IsolabilityOptions& options) {
    const Result<Isolability> answer = AnalyseIsolability(options);
    return answer.ok() ? std::string("accepted") : answer.error().field;
  };
  IsolabilityOptions options = BenchOptions();
  options.window_samples = 0;
  EXPECT_EQ(field(options), "window_samples");
  options = BenchOptions();
  options.window_samples = 245;
  EXPECT_EQ(field(options), "window_samples");
  options = BenchOptions();
  options.uc_v[3] = NAN;
  EXPECT_EQ(field(options), "uc_v");
  options = BenchOptions();
  options.rig.delta_s = 0.02;
  EXPECT_EQ(field(options), "period_s");
  options = BenchOptions();
  options.detection_probability = 0.2;
  EXPECT_EQ(field(options), "detection_probability");
  options = BenchOptions();
  options.faults = {{paper::kR1, -1.0}};
  EXPECT_EQ(field(options), "faults");
}

}  // namespace
}  // namespace faultlab::core
