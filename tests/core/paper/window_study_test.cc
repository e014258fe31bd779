#include "core/paper/window_study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/paper/reproduction/reproduction.h"
#include "core/plant/coefficients.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

constexpr std::size_t kStart = 50;
constexpr std::size_t kChange = 1000;

std::vector<WindowStudyRow> Study(Component component, double value) {
  return StudyWindows(PaperRecord(paper::Bench(), TableFault{component, value}, 1),
                      kStart,
                      kChange,
                      PaperVariants())
      .value();
}

TEST(WindowStudy, RunsThePapersSixVariantsInOneCall) {
  const auto rows = Study(paper::kR1, 10.0);
  std::vector<std::string> names;
  std::vector<int> transients;
  for (const WindowStudyRow& row : rows) {
    names.push_back(row.name);
    transients.push_back(row.transient_samples);
    EXPECT_EQ(row.estimates.size(), 2000U);
    EXPECT_EQ(row.parameters.size(), 3U);
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{
                "swa_50", "swa_100", "swa_200", "sia_20_5", "sia_100_20", "sia_500_20"}));
  // SWA: K rows; SIA: K + m - 1, the paper's 0.24 s, 1.19 s and 5.19 s.
  EXPECT_EQ(transients, (std::vector<int>{50, 100, 200, 24, 119, 519}));
}

TEST(WindowStudy, LongerWindowsSpreadLessAndSettleLater) {
  const auto rows = Study(paper::kR1, 10.0);
  for (const int i : {0, 1, 3, 4}) {
    const WindowStudyRow& shorter = rows[static_cast<std::size_t>(i)];
    const WindowStudyRow& longer = rows[static_cast<std::size_t>(i + 1)];
    EXPECT_LT(longer.before[0].standard_deviation, shorter.before[0].standard_deviation) << i;
    EXPECT_LT(shorter.settling_samples, longer.settling_samples) << i;
  }
  for (const WindowStudyRow& row : rows) {
    EXPECT_GT(row.settling_samples, 0) << row.name;
    EXPECT_LE(row.settling_samples, row.transient_samples) << row.name;
  }
}

TEST(WindowStudy, MeansAreThePlantsOnBothSidesOfTheChange) {
  // R12 changes only the gain, which every variant estimates without bias.
  PlantParameters faulty = paper::Plant();
  faulty.Set(paper::kR12, 2e3);
  const double before = MakeContinuous(paper::Plant()).b0;
  const double after = MakeContinuous(faulty).b0;
  for (const WindowStudyRow& row : Study(paper::kR12, 2e3)) {
    if (row.spec.method == EstimatorMethod::kSia) {
      // Coulomb friction lowers um by some millivolts of its volts.
      EXPECT_NEAR(row.before[0].mean, before, 0.01 * before) << row.name;
      EXPECT_NEAR(row.after[0].mean, after, 0.015 * after) << row.name;
    }
  }
}

TEST(WindowStudy, WithoutAChangeThereIsNoAfter) {
  const std::vector<Sample> record = PaperRecord(paper::Bench(), std::nullopt, 1);
  const auto rows = StudyWindows(record, kStart, record.size(), PaperVariants()).value();
  for (const WindowStudyRow& row : rows) {
    EXPECT_TRUE(row.after.empty());
    EXPECT_EQ(row.settling_samples, -1);
  }
}

TEST(WindowStudy, RefusalsNameTheField) {
  const std::vector<Sample> record = PaperRecord(paper::Bench(), std::nullopt, 1);
  EXPECT_EQ(StudyWindows(record, 100, 100, PaperVariants()).error().field, "change");
  EXPECT_EQ(StudyWindows(record, 0, 2001, PaperVariants()).error().field, "change");
  EXPECT_EQ(StudyWindows(record, 0, 300, PaperVariants()).error().field, "5/window_samples");
  std::vector<VariantSpec> bad(2);
  bad[1].order = 7;
  EXPECT_EQ(StudyWindows(record, 0, 1000, bad).error().field, "1/order");
}

}  // namespace
}  // namespace faultlab::core
