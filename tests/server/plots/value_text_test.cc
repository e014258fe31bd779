#include "server/plots/value_text.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/plots/figure.h"
#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

TEST(ValueText, GivesElectricalUnitsAPrefix) {
  EXPECT_EQ(ValueText(100, "ohm"), "100 Ω");
  EXPECT_EQ(ValueText(5600, "ohm"), "5.6 kΩ");
  EXPECT_EQ(ValueText(47e-12, "farad"), "47 pF");
  EXPECT_EQ(ValueText(1e-6, "farad"), "1 µF");
  EXPECT_EQ(ValueText(9.9996e3, "ohm"), "10 kΩ");
  EXPECT_EQ(ValueText(999.96, "ohm"), "1 kΩ") << "rounding may reach the next prefix";
}

TEST(ValueText, WritesMechanicalUnitsWithAPowerOfTen) {
  EXPECT_EQ(ValueText(1.43e-6, "kg m^2"), "1.43·10^{\u22126} kg·m²");
  EXPECT_EQ(ValueText(1.8e-4, "Nm/(rad/s)"), "1.8·10^{\u22124} Nm·s/rad");
  EXPECT_EQ(ValueText(0.5, "V"), "0.5 V");
}

/// As the page writes them (web/src/i18n/quantity.ts).
TEST(ValueText, CarriesTheDigitsThatItsErrorLeaves) {
  EXPECT_EQ(ValueWithErrorText(99.62, 0.41, "ohm"), "99.6 ± 0.4 Ω");
  EXPECT_EQ(ValueWithErrorText(99.62, 0.126, "ohm"), "99.62 ± 0.13 Ω");
  EXPECT_EQ(ValueWithErrorText(5601.0, 8.0, "ohm"), "5.601 ± 0.008 kΩ");
  EXPECT_EQ(ValueWithErrorText(1.432e-6, 2e-8, "kg m^2"), "(1.43 ± 0.02)·10^{−6} kg·m²");
  EXPECT_EQ(ValueWithErrorText(0.5, 0.02, "V"), "0.50 ± 0.02 V");
  EXPECT_EQ(ValueWithErrorText(100.0, NAN, "ohm"), "100 Ω");
}

TEST(ValueText, SetsTheNumberOfAPartBelowTheLine) {
  EXPECT_EQ(ComponentLabel(paper::kR12), "R_{12}");
  EXPECT_EQ(ComponentLabel(paper::kRa), "R_{a}");
  EXPECT_EQ(ComponentLabel(paper::kJ), "J");
  EXPECT_EQ(PlainText("b_{0d} in 10^{\u22126}"), "b0d in 10\u22126");
  EXPECT_EQ(PlainText("a_{b"), "a_{b") << "an open bracket is no mark-up";
}

}  // namespace
}  // namespace faultlab::server
