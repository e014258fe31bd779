#include "server/methods/same_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

TEST(SameKinds, HoldsWhatNoSensorSeparatesOfEachFault) {
  const std::vector<core::FaultSize> faults = {{paper::kR9, 33e3}, {paper::kJ, 1.43e-5}};
  const auto kinds = SameKinds(paper::Bench(), core::Channels::kUmOnly, faults);
  EXPECT_THAT(kinds,
              ElementsAre(UnorderedElementsAre(paper::kR9, paper::kR12), ElementsAre(paper::kJ)));
}

TEST(SameKinds, AFaultThatCannotBeJudgedStandsAloneAndSpoilsNoOther) {
  const std::vector<core::FaultSize> faults = {{paper::kR12, -5.0}, {paper::kR9, 33e3}};
  const auto kinds = SameKinds(paper::Bench(), core::Channels::kUmOnly, faults);
  EXPECT_THAT(kinds,
              ElementsAre(ElementsAre(paper::kR12), UnorderedElementsAre(paper::kR9, paper::kR12)));
  EXPECT_TRUE(SameKinds(paper::Bench(), core::Channels::kUmOnly, {}).empty());
}

}  // namespace
}  // namespace faultlab::server
