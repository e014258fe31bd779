#include "core/types/component.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

using testing::ElementsAre;

TEST(Component, EveryNameParsesBackToItself) {
  for (const Component component : kAllComponents) {
    EXPECT_EQ(ParseComponent(Name(component)), component) << Name(component);
  }
}

TEST(Component, ParsingIsExactAboutSpelling) {
  EXPECT_EQ(ParseComponent("r1"), std::nullopt);
  EXPECT_EQ(ParseComponent("R1 "), std::nullopt);
  EXPECT_EQ(ParseComponent(""), std::nullopt);
}

TEST(Component, RelayBoardsCarryTheValuesOfTable2) {
  EXPECT_THAT(RelayValues(Component::kR1), ElementsAre(1.0, 10.0, 56.0, 100.0));
  EXPECT_THAT(RelayValues(Component::kR9), ElementsAre(10e3, 33e3, 56e3, 100e3));
  EXPECT_THAT(RelayValues(Component::kC8), ElementsAre(47e-12, 1e-6, 10e-6, 47e-6));
}

TEST(Component, MotorPartsHaveNoRelays) {
  for (const Component component : {Component::kRa, Component::kJ, Component::kB}) {
    EXPECT_FALSE(IsRelaySwitched(component));
    EXPECT_THROW(RelayValues(component), ContractError);
  }
}

}  // namespace
}  // namespace faultlab::core
