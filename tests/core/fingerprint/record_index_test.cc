#include "core/fingerprint/record_index.h"

#include <gtest/gtest.h>

#include <algorithm>
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
std::vector<Sample> RecordOf(std::uint64_t seed, std::uint64_t prbs_seed = 1) {
  const std::vector<std::vector<Fault>> kPool = {{},
                                                 {AbruptFault(paper::kR9, 33e3)},
                                                 {AbruptFault(paper::kR1, 10.0)},
                                                 {AbruptFault(paper::kRa, 6.0)},
                                                 {AbruptFault(paper::kJ, 1.6e-5)}};
  PrbsSpec spec;
  spec.seed = prbs_seed;
  const std::vector<double> uc = MakePrbs(spec, 2000, paper::kPeriodS);
  return SimulateRecord(
      paper::Hardware(), paper::Plant(), uc, kPool[seed % kPool.size()], seed, paper::kPeriodS);
}

std::vector<std::int64_t> IdsOf(const RecordIndex& index, std::span<const Sample> brought) {
  std::vector<std::int64_t> ids;
  for (const RecordIndex::Copy& copy : index.Find(brought).copies) ids.push_back(copy.id);
  return ids;
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
      const std::vector<RecordIndex::Copy> copies = index_->Find(copy).copies;
      if (copies.empty()) continue;
      EXPECT_EQ(copies.size(), 1U);
      EXPECT_EQ(copies.front().id, id);
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
  EXPECT_EQ(IdsOf(*index_, mine), (std::vector<std::int64_t>{3}));
}

/// What a spreadsheet does in a minute, and the diagnosis still reads.
TEST_F(Class, FindsARecordHoweverItsCellsAreChanged) {
  const std::vector<std::int64_t> third = {3};
  const std::vector<Sample>& record = (*records_)[3];
  const auto changed = [&record](auto change) {
    std::vector<Sample> copy = record;
    for (std::size_t k = 0; k < copy.size(); ++k) change(copy[k], k);
    return copy;
  };
  for (const double absurd : {1e5, 1e6, 1e300, -1e308}) {
    for (double Sample::*channel : {&Sample::uc_v, &Sample::um_v, &Sample::n_rpm}) {
      const auto copy = changed([&](Sample& sample, std::size_t k) {
        sample.ua_v = sample.ia_a = kAbsent;
        if (k == 700) sample.*channel = absurd;
      });
      EXPECT_EQ(IdsOf(*index_, copy), third) << absurd;
    }
  }
  EXPECT_EQ(IdsOf(*index_, changed([](Sample& sample, std::size_t k) {
              sample.ua_v = sample.ia_a = sample.n_rpm = kAbsent;
              if (k % 2 == 1) sample.um_v = kAbsent;
            })),
            third)
      << "every other reading is missing";
  EXPECT_EQ(IdsOf(*index_, changed([](Sample& sample, std::size_t) {
              sample.uc_v *= -1.0;
              sample.um_v *= -1.0;
              sample.ua_v = sample.ia_a = sample.n_rpm = kAbsent;
            })),
            third)
      << "mirrored";
  Random random(3);
  std::vector<Sample> thinned;
  for (const Sample& sample : record) {
    if (random.Below(10) > 0) thinned.push_back(sample);
  }
  EXPECT_EQ(IdsOf(*index_, thinned), third) << "one row in ten is missing";
  for (const std::size_t every : {2U, 3U, 5U}) {
    std::vector<Sample> slower;
    for (std::size_t k = 0; k < record.size(); k += every) {
      slower.push_back(record[k]);
      slower.back().index = static_cast<std::int64_t>(slower.size()) - 1;
    }
    EXPECT_EQ(IdsOf(*index_, slower), third) << "every " << every << ".";
  }
}

TEST_F(Class, FindsAllRecordsInOneFile) {
  std::vector<Sample> both = (*records_)[3];
  for (Sample sample : (*records_)[8]) {
    sample.index += 2000;
    both.push_back(sample);
  }
  std::vector<std::int64_t> ids = IdsOf(*index_, both);
  std::ranges::sort(ids);
  EXPECT_EQ(ids, (std::vector<std::int64_t>{3, 8}));
}

TEST(RecordIndex, FindsARecordOfSteps) {
  const auto run = [](std::uint64_t seed) {
    std::vector<double> uc(2000, 2.0);
    for (std::size_t k = 0; k < uc.size(); ++k) uc[k] = k % 500 < 250 ? 2.0 : 3.0;
    return SimulateRecord(paper::Hardware(), paper::Plant(), uc, {}, seed, paper::kPeriodS);
  };
  RecordIndex index;
  index.Put(1, run(1));
  std::vector<Sample> dithered = run(1);
  Random random(1);
  for (Sample& sample : dithered) sample.uc_v += 1e-3 * random.Normal();
  EXPECT_EQ(IdsOf(index, dithered), (std::vector<std::int64_t>{1}));
  EXPECT_TRUE(IdsOf(index, run(2)).empty());
}

TEST(RecordIndex, SaysHowMuchItCompares) {
  RecordIndex index;
  for (std::uint64_t id = 0; id < 12; ++id) {
    index.Put(static_cast<std::int64_t>(id), RecordOf(id, 17 * id + 3));
  }
  std::vector<Sample> endless(1'000'000);
  for (std::size_t k = 0; k < endless.size(); ++k) {
    endless[k].index = static_cast<std::int64_t>(k);
    endless[k].uc_v = static_cast<double>(k % 2);
  }
  const RecordIndex::Found found = index.Find(endless);
  ASSERT_TRUE(found.samples_most.has_value());
  EXPECT_FALSE(index.Find(std::span(endless).first(1000)).samples_most.has_value());
  EXPECT_GT(*found.samples_most, 100'000U);
  EXPECT_LT(*found.samples_most, endless.size());
  const std::vector<Sample> stranger = RecordOf(77, 9999);
  EXPECT_FALSE(index.Find(stranger).samples_most.has_value());
  const double least = index.CostOf(stranger.size());
  EXPECT_TRUE(index.Find(stranger, 1.01 * least).samples_most.has_value())
      << "what the first look promises is paid for too";
}

TEST_F(Class, TakesNoRunOfOnesOwnForACopy) {
  for (std::uint64_t seed = 5000; seed < 5100; ++seed) {
    EXPECT_TRUE(IdsOf(*index_, RecordOf(seed)).empty()) << seed;
  }
}

TEST(RecordIndex, KnowsARecordFromItsFirstSecondsOn) {
  const std::vector<Sample> record = RecordOf(1);
  RecordIndex index;
  index.Put(1, std::span(record).first(100));
  EXPECT_TRUE(IdsOf(index, std::span(record).first(400)).empty());
  index.Put(1, std::span(record).first(300));
  EXPECT_FALSE(IdsOf(index, std::span(record).first(300)).empty());
  EXPECT_TRUE(IdsOf(index, std::span(record).subspan(300)).empty());
  index.Put(1, record);
  EXPECT_FALSE(IdsOf(index, std::span(record).subspan(300)).empty());
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
  EXPECT_TRUE(IdsOf(index, record).empty());
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
  EXPECT_TRUE(IdsOf(index, still).empty());
  EXPECT_TRUE(IdsOf(index, {}).empty());
}

}  // namespace
}  // namespace faultlab::core
