// Faults that come and go one after the other, as somebody moves sliders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/diagnosis/pipeline.h"
#include "core/isolability/isolability.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "hardware/bench/benches.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

struct Step {
  double at_s;
  std::string what;
  std::vector<Component> present;  // from then on
};

struct Sequence {
  std::vector<Step> steps;
  std::vector<Sample> samples;
};

// Every 3 to 7 s one of the listed faults comes, or one that is there goes. `slowly`: every other
// one comes within half a second to one.
Sequence SequenceOf(const Bench& bench, unsigned seed, std::size_t at_once, bool slowly) {
  std::mt19937 random(seed);
  const auto real = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto below = [&](std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
  };
  const std::vector<FaultSize> listed = FaultsOf(bench);
  Sequence sequence;
  sequence.steps.push_back({0.0, "", {}});
  std::vector<Component> present;
  std::vector<Fault> faults;
  for (double at_s = 8.0; at_s < 60.0; at_s += real(3.0, 7.0)) {
    Fault fault;
    fault.at_s = at_s;
    if (present.size() == at_once || (!present.empty() && below(2) == 0)) {
      const auto gone = present.begin() + static_cast<std::ptrdiff_t>(below(present.size()));
      fault.component = *gone;
      fault.value = bench.nominal.Get(*gone);
      present.erase(gone);
    } else {
      const FaultSize& size = listed[below(listed.size())];
      if (std::find(present.begin(), present.end(), size.component) != present.end()) continue;
      fault.component = size.component;
      fault.value = size.value;
      if (slowly && below(2) == 0) {
        fault.kind = FaultKind::kDrift;
        fault.until_s = at_s + real(0.5, 1.0);
      }
      present.push_back(size.component);
    }
    faults.push_back(fault);
    sequence.steps.push_back({at_s,
                              sequence.steps.back().what + " " +
                                  std::string(Name(fault.component)) + "=" +
                                  std::to_string(fault.value),
                              present});
  }
  PrbsSpec input;
  input.seed = seed;
  input.low_v = 0.15 * bench.limits.uc_v_max;
  input.high_v = 0.55 * bench.limits.uc_v_max;
  input.clock_s = bench.um.exists || bench.ia.exists ? 2.0 * bench.period_s : 0.05;
  const auto samples = static_cast<int>(std::lround(65.0 / bench.period_s));
  sequence.samples = SimulateRecord(bench.profiles.front(),
                                    bench.nominal,
                                    MakePrbs(input, samples, bench.period_s),
                                    faults,
                                    seed,
                                    bench.period_s);
  return sequence;
}

void ExpectSaid(const Verdict& verdict, const Step& step) {
  SCOPED_TRACE(step.what + ": " + verdict.reason);
  if (step.present.empty()) {
    EXPECT_EQ(verdict.kind, VerdictKind::kNominal);
    return;
  }
  EXPECT_EQ(verdict.kind, VerdictKind::kFault);
  EXPECT_TRUE(std::any_of(step.present.begin(), step.present.end(), [&](Component each) {
    return std::find(verdict.group.begin(), verdict.group.end(), each) != verdict.group.end();
  }));
  const bool two = verdict.reason.find("on top of") != std::string::npos;
  EXPECT_TRUE(!two || step.present.size() > 1);
}

// What is said just before the next change.
void ExpectFollowed(const Bench& bench, unsigned seed, std::size_t at_once, bool slowly = false) {
  SCOPED_TRACE(bench.name + ", seed " + std::to_string(seed));
  const Sequence sequence = SequenceOf(bench, seed, at_once, slowly);
  const DiagnosisOptions options = OptionsOf(bench);
  Pipeline pipeline(options);
  std::size_t now = 0;
  for (const Sample& sample : sequence.samples) {
    if (now + 1 < sequence.steps.size() &&
        sample.t_s >= sequence.steps[now + 1].at_s - bench.period_s) {
      ExpectSaid(pipeline.verdict(), sequence.steps[now]);
      ++now;
    }
    pipeline.Push(sample);
    while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
  }
  ExpectSaid(pipeline.verdict(), sequence.steps[now]);
}

class Sequences : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Benches, Sequences, testing::Values("gear-motor", "speed-motor"));

TEST_P(Sequences, OfOneFaultAtATimeAreFollowed) {
  const Bench& bench = *hardware::LoadBench(GetParam()).value();
  for (const unsigned seed : tests::Seeds(1, 7)) ExpectFollowed(bench, seed, 1);
}

TEST(SlowFaults, InSequencesAreFollowed) {
  const Bench& gear = *hardware::LoadBench("gear-motor").value();
  for (const unsigned seed : tests::Seeds(1, 7)) ExpectFollowed(gear, seed, 1, true);
  ExpectFollowed(*hardware::LoadBench("servo-motor").value(), 1, 1, true);
  const Bench& speed = *hardware::LoadBench("speed-motor").value();
  for (const unsigned seed : tests::Seeds(1, 7)) ExpectFollowed(speed, seed, 1, true);
}

// A part that goes on moving is one fault: a few alarms, then where it is, and no alarm any more.
TEST_P(Sequences, OfValuesOfOneThatMovesAreOneFault) {
  const Bench& bench = *hardware::LoadBench(GetParam()).value();
  const Component gain = bench.Find("k").value();
  Fault fault;
  fault.component = gain;
  fault.value = 1.6 * bench.nominal.Get(gain);
  fault.at_s = 10.0;
  fault.kind = FaultKind::kDrift;
  fault.until_s = 30.0;
  PrbsSpec input;
  input.low_v = 0.15 * bench.limits.uc_v_max;
  input.high_v = 0.55 * bench.limits.uc_v_max;
  input.clock_s = 0.05;
  const std::vector<Sample> samples =
      SimulateRecord(bench.profiles.front(),
                     bench.nominal,
                     MakePrbs(input, static_cast<int>(40.0 / bench.period_s), bench.period_s),
                     std::vector{fault},
                     5,
                     bench.period_s);
  const DiagnosisOptions options = OptionsOf(bench);
  Pipeline pipeline(options);
  for (const Sample& sample : samples) {
    pipeline.Push(sample);
    while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
    const Verdict& verdict = pipeline.verdict();
    const bool names =
        std::find(verdict.group.begin(), verdict.group.end(), gain) != verdict.group.end();
    EXPECT_TRUE(names || sample.t_s < 18.0) << sample.t_s << ": " << verdict.reason;
  }
  const Diagnosis diagnosis = pipeline.Finish();
  ASSERT_EQ(diagnosis.episodes.size(), 1U);
  EXPECT_EQ(diagnosis.episodes.front().shape, FaultShape::kDrift);
  ASSERT_FALSE(diagnosis.verdict.candidates.empty());
  EXPECT_NEAR(diagnosis.verdict.candidates.front().value, fault.value, 0.01 * fault.value);
}

TEST(TwoFaults, InSequencesAreFollowed) {
  const Bench& gear = *hardware::LoadBench("gear-motor").value();
  for (const unsigned seed : tests::Seeds(1, 5)) ExpectFollowed(gear, seed, 2);
  ExpectFollowed(*hardware::LoadBench("servo-motor").value(), 1, 2);
}

}  // namespace
}  // namespace faultlab::core
