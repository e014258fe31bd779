#include "core/types/component.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/check.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Component, EveryNameParsesBackToItself) {
  for (const Component component : paper::Parts()) {
    EXPECT_EQ(paper::Bench().Find(Name(component)), component) << Name(component);
  }
}

TEST(Component, ParsingIsExactAboutSpelling) {
  EXPECT_EQ(paper::Bench().Find("r1"), std::nullopt);
  EXPECT_EQ(paper::Bench().Find("R1 "), std::nullopt);
  EXPECT_EQ(paper::Bench().Find(""), std::nullopt);
}

TEST(Component, RelayBoardsCarryTheValuesOfTable2) {
  EXPECT_THAT(paper::RelayValues(paper::kR1), ElementsAre(1.0, 10.0, 56.0, 100.0));
  EXPECT_THAT(paper::RelayValues(paper::kR9), ElementsAre(10e3, 33e3, 56e3, 100e3));
  EXPECT_THAT(paper::RelayValues(paper::kC8), ElementsAre(47e-12, 1e-6, 10e-6, 47e-6));
}

TEST(Component, MotorPartsHaveNoRelays) {
  for (const Component component : {paper::kRa, paper::kJ, paper::kB}) {
    EXPECT_FALSE(IsSwitched(component));
    EXPECT_THAT(paper::RelayValues(component), IsEmpty());
  }
}

TEST(Component, NoneOfABenchIsABugThatIsNoticed) {
  EXPECT_FALSE(Component().exists());
  EXPECT_THROW(Name(Component()), ContractError);
}

}  // namespace
}  // namespace faultlab::core
