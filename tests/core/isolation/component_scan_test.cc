#include "core/isolation/component_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/core/isolation/fault_stretch.h"

namespace faultlab::core {
namespace {

TEST(ScanComponents, ComesNearTheValueOfEachKindOfFault) {
  const std::vector<std::pair<Component, double>> faults = {{Component::kR1, 33.0},
                                                            {Component::kR9, 33e3},
                                                            {Component::kR12, 2.7e3},
                                                            {Component::kC8, 4.7e-6},
                                                            {Component::kRa, 3.3},
                                                            {Component::kJ, 1.43e-5},
                                                            {Component::kB, 9e-5}};
  std::uint64_t seed = 83;
  for (const auto& [component, value] : faults) {
    FaultStretch fault({AbruptFault(component, value, 1.0)}, ++seed);
    const auto fits = ScanComponents(fault.context, kAllComponents);
    ASSERT_EQ(fits.size(), kAllComponents.size());
    const HypothesisFit& own = fits[static_cast<std::size_t>(Index(component))];
    EXPECT_EQ(own.component, component);
    // Twelve golden sections of two steps of the scan leave less than a percent, noise some
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
  FaultStretch fault({AbruptFault(Component::kRa, 3.3, 1.0)}, 95);
  const std::vector<Component> asked = {Component::kC8, Component::kRa};
  const auto fits = ScanComponents(fault.context, asked);
  ASSERT_EQ(fits.size(), 2U);
  EXPECT_EQ(fits[0].component, Component::kC8);
  EXPECT_EQ(fits[1].component, Component::kRa);
  EXPECT_GT(fits[0].cost, fits[1].cost + 100.0);
}

}  // namespace
}  // namespace faultlab::core
