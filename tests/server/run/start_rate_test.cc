#include "server/run/start_rate.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

using std::chrono::seconds;

TEST(StartRate, LetsABurstThroughAndThenSoManyASecond) {
  StartRate rate(3.0, 0.5);
  MonotonicTime now{};
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(rate.Take("ann", now).ok());
  const core::Status refused = rate.Take("ann", now);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kTooMany);
  EXPECT_EQ(refused.error().reason, "runs_too_fast");
  EXPECT_EQ(refused.error().parameters.at(0).value, "2");
  EXPECT_TRUE(rate.Take("bob", now).ok()) << "others are not held up";
  now += seconds(2);
  EXPECT_TRUE(rate.Take("ann", now).ok());
  EXPECT_FALSE(rate.Take("ann", now).ok());
  now += seconds(1000);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(rate.Take("ann", now).ok());
  EXPECT_FALSE(rate.Take("ann", now).ok()) << "no more than a burst is saved up";
}

TEST(StartRate, ForgetsNobodyWhoHasNoMoreLeft) {
  StartRate rate(1.0, 0.001);
  const MonotonicTime now{};
  EXPECT_TRUE(rate.Take("ann", now).ok());
  for (int i = 0; i < 5000; ++i) EXPECT_TRUE(rate.Take(std::to_string(i), now).ok());
  EXPECT_FALSE(rate.Take("ann", now).ok());
}

}  // namespace
}  // namespace faultlab::server
