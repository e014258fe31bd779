#include "core/isolation/component_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/core/isolation/fault_stretch.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

TEST(ScanComponents, ComesNearTheValueOfEachKindOfFault) {
  const std::vector<std::pair<Component, double>> faults = {{paper::kR1, 33.0},
                                                            {paper::kR9, 33e3},
                                                            {paper::kR12, 2.7e3},
                                                            {paper::kC8, 4.7e-6},
                                                            {paper::kRa, 3.3},
                                                            {paper::kJ, 1.43e-5},
                                                            {paper::kB, 9e-5}};
  std::uint64_t seed = 83;
  for (const auto& [component, value] : faults) {
    FaultStretch fault({AbruptFault(component, value, 1.0)}, ++seed);
    const auto fits = ScanComponents(fault.context, paper::Parts());
    ASSERT_EQ(fits.size(), paper::Parts().size());
    const HypothesisFit& own = fits[static_cast<std::size_t>(Index(component))];
    EXPECT_EQ(own.component, component);
    // Twelve golden sections of two steps of the scan leave less than a percent; noise adds some
    // percent.
    EXPECT_NEAR(own.value, value, 0.1 * value) << Name(component);
    EXPECT_TRUE(std::isnan(own.log_sigma));
    const double lowest =
        std::min_element(fits.begin(), fits.end(), [](const auto& a, const auto& b) {
          return a.cost < b.cost;
        })->cost;
    // R9 and R12 change the same gain.
    EXPECT_LT(own.cost - lowest, 9.0) << Name(component);
  }
}

TEST(ScanComponents, ScansOnlyWhatItIsAskedFor) {
  FaultStretch fault({AbruptFault(paper::kRa, 3.3, 1.0)}, 95);
  const std::vector<Component> asked = {paper::kC8, paper::kRa};
  const auto fits = ScanComponents(fault.context, asked);
  ASSERT_EQ(fits.size(), 2U);
  EXPECT_EQ(fits[0].component, paper::kC8);
  EXPECT_EQ(fits[1].component, paper::kRa);
  EXPECT_GT(fits[0].cost, fits[1].cost + 100.0);
}

}  // namespace
}  // namespace faultlab::core
