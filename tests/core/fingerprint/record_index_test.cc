#include "core/fingerprint/record_index.h"

#include <gtest/gtest.h>

#include <functional>
#include <span>
#include <vector>

#include "core/signals/random.h"
#include "tests/core/bench_records.h"
#include "tests/core/fingerprint/disguise.h"

namespace faultlab::core {
namespace {

const OwnNoise kOwn = {15e-3, 15e-3, 1e-3, 0.5};  // of benches/paper.toml

/// One of several faults of a class, or none, from 10 s on.
std::vector<Sample> RecordOf(std::uint64_t seed) {
  const std::vector<std::vector<Fault>> kPool = {{},
                                                 {AbruptFault(paper::kR9, 33e3)},
                                                 {AbruptFault(paper::kR1, 10.0)},
                                                 {AbruptFault(paper::kRa, 6.0)},
                                                 {AbruptFault(paper::kJ, 1.6e-5)}};
  PrbsSpec spec;
  const std::vector<double> uc = MakePrbs(spec, 2000, paper::kPeriodS);
  return SimulateRecord(
      paper::Hardware(), paper::Plant(), uc, kPool[seed % kPool.size()], seed, paper::kPeriodS);
}

/// A class of 30 in one exercise: all play the same voltages.
class Class : public testing::Test {
 protected:
  static constexpr std::int64_t kRecords = 30;

  static void SetUpTestSuite() {
    records_ = new std::vector<std::vector<Sample>>;
    index_ = new RecordIndex;
    for (std::int64_t id = 0; id < kRecords; ++id) {
      records_->push_back(RecordOf(1000 + static_cast<std::uint64_t>(id)));
      index_->Put(id, records_->back());
    }
  }
  static void TearDownTestSuite() {
    delete index_;
    delete records_;
  }

  /// How many of `trials` copies are found as what they are; a wrong one fails at once.
  static int Found(int trials, const std::function<Disguise(Random&)>& draw) {
    Random random(7);
    int found = 0;
    for (int trial = 0; trial < trials; ++trial) {
      const std::int64_t id = trial % kRecords;
      const auto copy = Dress(
          (*records_)[static_cast<std::size_t>(id)], draw(random), kOwn, paper::kPeriodS, random);
      const auto match = index_->Find(copy);
      if (!match) continue;
      EXPECT_EQ(match->id, id);
      ++found;
    }
    return found;
  }

  static std::vector<std::vector<Sample>>* records_;
  static RecordIndex* index_;
};

std::vector<std::vector<Sample>>* Class::records_ = nullptr;
RecordIndex* Class::index_ = nullptr;

Disguise TwoSeconds(Random& random) {
  Disguise disguise;
  disguise.from = random.Below(1750);
  return disguise;
}

TEST_F(Class, FindsTwentyDisguisesOfARecord) {
  EXPECT_EQ(Found(20, [](Random& random) { return DrawDisguise(2000, 1500, 1.0, random); }), 20);
}

TEST_F(Class, FindsTwoSecondsOfARecord) {
  EXPECT_EQ(Found(30, TwoSeconds), 30);
}

TEST_F(Class, FindsTwoSecondsInWhateverWayTheyAreChanged) {
  const auto changed = [](auto change) {
    return [change](Random& random) {
      Disguise disguise = TwoSeconds(random);
      change(disguise, random);
      return disguise;
    };
  };
  EXPECT_GE(Found(30, changed([](Disguise& d, Random&) { d.um_alone = true; })), 29);
  EXPECT_EQ(Found(30, changed([](Disguise& d, Random&) { d.bits = 8; })), 30);
  EXPECT_EQ(Found(30, changed([](Disguise& d, Random&) { d.noise = 2.0; })), 30);
  EXPECT_EQ(Found(30, changed([](Disguise& d, Random& random) {
                    d.scale = random.Uniform(0.3, 3.0);
                    d.command_scale = random.Uniform(0.3, 3.0);
                    d.offset = random.Uniform(-1.0, 1.0);
                  })),
            30);
  EXPECT_GE(
      Found(30, changed([](Disguise& d, Random& random) { d.rate = random.Uniform(0.95, 1.05); })),
      29);
}

TEST_F(Class, OutliersBlindNobody) {
  EXPECT_EQ(Found(10,
                  [](Random& random) {
                    Disguise disguise = TwoSeconds(random);
                    disguise.from = random.Below(400);
                    disguise.samples = 1500;
                    disguise.outliers = 40;
                    disguise.um_alone = true;
                    return disguise;
                  }),
            10);
}

TEST_F(Class, FindsAPartThatStandsInARunOfOnesOwn) {
  std::vector<Sample> mine = RecordOf(77);
  for (std::size_t k = 1000; k < 1400; ++k) {
    const Sample& theirs = (*records_)[3][k];
    mine[k].um_v = theirs.um_v;
  }
  const auto match = index_->Find(mine);
  ASSERT_TRUE(match.has_value());
  EXPECT_EQ(match->id, 3);
}

TEST_F(Class, TakesNoRunOfOnesOwnForACopy) {
  for (std::uint64_t seed = 5000; seed < 5100; ++seed) {
    EXPECT_FALSE(index_->Find(RecordOf(seed)).has_value()) << seed;
  }
}

TEST(RecordIndex, KnowsARecordFromItsFirstSecondsOn) {
  const std::vector<Sample> record = RecordOf(1);
  RecordIndex index;
  index.Put(1, std::span(record).first(100));
  EXPECT_FALSE(index.Find(std::span(record).first(400)).has_value());
  index.Put(1, std::span(record).first(300));
  EXPECT_TRUE(index.Find(std::span(record).first(300)).has_value());
  EXPECT_FALSE(index.Find(std::span(record).subspan(300)).has_value());
  index.Put(1, record);
  EXPECT_TRUE(index.Find(std::span(record).subspan(300)).has_value());
  EXPECT_EQ(index.size(), 1U);
}

TEST(RecordIndex, ForgetsWhatIsRemoved) {
  const std::vector<Sample> record = RecordOf(1);
  RecordIndex index;
  index.Put(1, record);
  index.Put(2, RecordOf(2));
  index.Remove(1);
  index.Remove(9);
  EXPECT_EQ(index.size(), 1U);
  EXPECT_FALSE(index.Find(record).has_value());
}

TEST(RecordIndex, HasNothingToSayOfARecordWithoutNoise) {
  std::vector<Sample> still(500);
  for (std::size_t k = 0; k < still.size(); ++k) {
    still[k].index = static_cast<std::int64_t>(k);
    still[k].uc_v = k % 64 < 32 ? 2.0 : 3.0;
    still[k].um_v = 2.0 * still[k].uc_v;
  }
  RecordIndex index;
  index.Put(1, still);
  EXPECT_FALSE(index.Find(still).has_value());
  EXPECT_FALSE(index.Find({}).has_value());
}

}  // namespace
}  // namespace faultlab::core
