#include "server/lab/relay_wear.h"

#include <gmock/gmock.h>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

class RelayWearTest : public testing::TestWithParam<Engine> {
 protected:
  tests::TestDatabase database_{GetParam()};
  RelayWear wear_{*database_};
};

TEST_P(RelayWearTest, AddsUpTheClosingsOfEachLineUntilTheRelayIsReplaced) {
  ASSERT_TRUE(wear_.Add("bench-1", {{16, 2}, {17, 1}}, FromMilliseconds(1000)).ok());
  ASSERT_TRUE(wear_.Add("bench-1", {{16, 40}}, FromMilliseconds(2000)).ok());
  ASSERT_TRUE(wear_.Add("bench-2", {{16, 7}}, FromMilliseconds(2000)).ok());
  auto counts = wear_.Get("bench-1").value();
  EXPECT_EQ(counts.at(16).cycles, 42);
  EXPECT_EQ(counts.at(16).since, FromMilliseconds(1000));
  EXPECT_EQ(counts.at(17).cycles, 1);
  ASSERT_TRUE(wear_.Replaced("bench-1", 16, FromMilliseconds(3000)).ok());
  ASSERT_TRUE(wear_.Add("bench-1", {{16, 1}}, FromMilliseconds(4000)).ok());
  counts = wear_.Get("bench-1").value();
  EXPECT_EQ(counts.at(16).cycles, 1);
  EXPECT_EQ(counts.at(16).since, FromMilliseconds(3000));
  EXPECT_EQ(counts.at(17).cycles, 1) << "another relay";
  EXPECT_EQ(wear_.Get("bench-2").value().at(16).cycles, 7) << "another rig";
}

INSTANTIATE_TEST_SUITE_P(Engines, RelayWearTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab
