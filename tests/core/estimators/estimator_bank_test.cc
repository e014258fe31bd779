#include "core/estimators/estimator_bank.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/estimators/sia.h"
#include "core/estimators/swa.h"
#include "core/types/check.h"
#include "tests/core/estimators/records.h"
#include "tests/support/heap_guard.h"

namespace faultlab::core {
namespace {

using Answer = std::array<Estimate<3>, kEstimatorCount>;

std::vector<Sample> MakeSamples(int count, double noise_v, std::uint64_t seed) {
  const testing::Record record =
      testing::MakeFirstOrder(testing::MakeBinary(count, 1, seed), 9.5e-3, noise_v, seed);
  std::vector<Sample> samples;
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    Sample& sample = samples.emplace_back();
    sample.index = static_cast<std::int64_t>(k);
    sample.t_s = 0.01 * static_cast<double>(k);
    sample.uc_v = record.u[k];
    sample.um_v = record.y[k];
  }
  return samples;
}

bool SameBits(const Answer& a, const Answer& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  bool equal = true;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      equal &= same(a[i].theta[j], b[i].theta[j]) && same(a[i].sigma[j], b[i].sigma[j]);
    }
    equal &= same(a[i].sse, b[i].sse) && same(a[i].condition, b[i].condition);
    equal &= a[i].status == b[i].status && a[i].age_samples == b[i].age_samples;
  }
  return equal;
}

/// The six estimators one by one; the bank must give the same results.
class OneByOne {
 public:
  explicit OneByOne(const EstimatorBankOptions& options) : intake_(options.period_s, options.rail) {
    for (const EstimatorShape& shape : kEstimatorShapes) {
      if (shape.integral_samples == 0) {
        SwaOptions<1> swa;
        swa.window_samples = shape.window_samples;
        swa_.emplace_back(swa);
      } else {
        SiaOptions<1> sia;
        sia.window_samples = shape.window_samples;
        sia.integral_samples = shape.integral_samples;
        sia.mode = options.sia_mode;
        sia.delta_s = options.delta_s;
        sia_.emplace_back(sia);
      }
    }
  }

  void Push(const Sample& sample, Answer& out) {
    const SampleStep step = intake_.Classify(sample);
    std::size_t at = 0;
    for (Swa<1>& swa : swa_) {
      Feed(step, sample, swa);
      out[at++] = swa.estimate();
    }
    for (Sia<1>& sia : sia_) {
      Feed(step, sample, sia);
      out[at++] = sia.estimate();
    }
  }

 private:
  SampleIntake intake_;
  std::vector<Swa<1>> swa_;
  std::vector<Sia<1>> sia_;
};

/// Every kind of sample: noise, short and long gaps, clipped, non-finite, a constant input.
std::vector<Sample> RoughSamples() {
  std::vector<Sample> samples;
  for (Sample sample : MakeSamples(6000, 0.015, 1)) {
    const std::int64_t k = sample.index;
    if ((k % 701 > 690) || (k > 2000 && k < 2090) || (k > 3000 && k < 3700)) {
      continue;
    }
    if (k % 313 == 0) {
      sample.um_v = std::numeric_limits<double>::quiet_NaN();
    } else if (k % 97 == 0) {
      sample.um_v = 9.9999;
    } else if (k > 4300 && k < 5000) {
      sample.uc_v = 2.0;
      sample.um_v = 4.787;
    }
    samples.push_back(sample);
  }
  return samples;
}

TEST(EstimatorBank, GivesEachEstimatorsOwnAnswerBitForBitInTheOrderOfItsShapes) {
  for (const SiaMode mode : {SiaMode::kPaper, SiaMode::kExact}) {
    EstimatorBankOptions options;
    options.sia_mode = mode;
    EstimatorBank bank(options);
    OneByOne singles(options);
    Answer together;
    Answer alone;
    std::array<int, 4> seen{};
    for (const Sample& sample : RoughSamples()) {
      bank.Push(sample, together);
      singles.Push(sample, alone);
      ASSERT_TRUE(SameBits(together, alone)) << sample.index;
      for (const Estimate<3>& estimate : together) {
        ++seen[static_cast<std::size_t>(estimate.status)];
      }
    }
    for (const int count : seen) {
      EXPECT_GT(count, 0);  // every status was compared
    }
  }
}

TEST(EstimatorBank, FindsThePlantThatMadeTheRecord) {
  EstimatorBank bank;
  Answer answer;
  for (const Sample& sample : MakeSamples(700, 0.015, 1)) {
    bank.Push(sample, answer);
  }
  for (std::size_t i = 0; i < kEstimatorCount; ++i) {
    EXPECT_NE(answer[i].status, EstimateStatus::kInvalid) << kEstimatorShapes[i].name;
  }
  EXPECT_NEAR(answer[4].theta[0], testing::kB0, 0.05);
  EXPECT_NEAR(answer[5].theta[2], testing::kA1, 0.1 * testing::kA1);
}

TEST(EstimatorBank, FillsItsWindowsInTheOrderOfTheirLength) {
  EstimatorBank bank;
  std::array<int, kEstimatorCount> first{};
  Answer answer;
  for (const Sample& sample : MakeSamples(600, 0.0, 2)) {
    bank.Push(sample, answer);
    for (std::size_t i = 0; i < kEstimatorCount; ++i) {
      if (first[i] == 0 && answer[i].status != EstimateStatus::kInvalid) {
        first[i] = static_cast<int>(sample.index) + 1;
      }
    }
  }
  EXPECT_EQ(first, (std::array<int, kEstimatorCount>{50, 100, 200, 20, 100, 500}));
}

TEST(EstimatorBank, GivesBitEqualAnswersToTheSameSamples) {
  EstimatorBank first;
  EstimatorBank second;
  Answer a;
  Answer b;
  for (Sample sample : MakeSamples(1000, 0.015, 3)) {
    if (sample.index % 97 == 0) {
      sample.um_v = std::numeric_limits<double>::quiet_NaN();
    }
    first.Push(sample, a);
    second.Push(sample, b);
    ASSERT_TRUE(SameBits(a, b)) << sample.index;
  }
}

TEST(EstimatorBank, IgnoresRepeatedSamples) {
  EstimatorBank once;
  EstimatorBank twice;
  Answer a;
  Answer b;
  for (const Sample& sample : MakeSamples(600, 0.015, 4)) {
    once.Push(sample, a);
    twice.Push(sample, b);
    twice.Push(sample, b);
    ASSERT_TRUE(SameBits(a, b)) << sample.index;
  }
}

TEST(EstimatorBank, StaysTrueAcrossMissingSamples) {
  EstimatorBank bank;
  Answer answer;
  for (const Sample& sample : MakeSamples(1200, 0.0, 5)) {
    if (sample.index % 150 >= 147) {
      continue;  // three samples lost every 1.5 s
    }
    bank.Push(sample, answer);
    for (const Estimate<3>& estimate : answer) {
      if (estimate.status == EstimateStatus::kExcited) {
        ASSERT_LT(estimate.sse, 1e-9) << sample.index;
      }
    }
  }
  EXPECT_EQ(answer[1].status, EstimateStatus::kExcited);
  EXPECT_EQ(answer[4].status, EstimateStatus::kExcited);
}

TEST(EstimatorBank, LeavesClippedReadingsOut) {
  EstimatorBank bank;
  Answer answer;
  for (Sample sample : MakeSamples(600, 0.0, 6)) {
    if (sample.index % 20 == 0) {
      sample.um_v = 9.99969;
    }
    bank.Push(sample, answer);
  }
  EXPECT_EQ(answer[1].status, EstimateStatus::kExcited);
  EXPECT_LT(answer[1].sse, 1e-9);
}

TEST(EstimatorBank, NeverShowsAFreshNumberUnderConstantInput) {
  EstimatorBank bank;
  Answer answer;
  std::vector<Sample> samples = MakeSamples(1500, 0.015, 7);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k >= 700) {
      samples[k].uc_v = 2.0;
      samples[k].um_v = 4.787 + 0.001 * static_cast<double>(k % 7);
    }
    bank.Push(samples[k], answer);
    for (const Estimate<3>& estimate : answer) {
      if (estimate.status == EstimateStatus::kExcited) {
        for (double theta : estimate.theta) {
          ASSERT_LT(std::abs(theta), 100.0) << k;
        }
      }
    }
  }
  for (std::size_t i = 0; i < kEstimatorCount; ++i) {
    EXPECT_EQ(answer[i].status, EstimateStatus::kNotExcited) << kEstimatorShapes[i].name;
    EXPECT_GT(answer[i].age_samples, 200) << kEstimatorShapes[i].name;
  }
}

TEST(EstimatorBank, AllocatesNothingPerSample) {
  const std::vector<Sample> samples = MakeSamples(600, 0.015, 8);
  EstimatorBank bank;
  Answer answer;
  faultlab::testing::HeapGuard guard;
  for (const Sample& sample : samples) {
    bank.Push(sample, answer);
  }
  EXPECT_EQ(guard.allocations(), 0);
}

TEST(EstimatorBank, RefusesAReadingDelayBeyondThePeriod) {
  EXPECT_THROW(EstimatorBank({.period_s = 0.01, .delta_s = 0.02}), ContractError);
  EXPECT_THROW(EstimatorBank({.period_s = 0.0, .delta_s = 0.0}), ContractError);
}

}  // namespace
}  // namespace faultlab::core
