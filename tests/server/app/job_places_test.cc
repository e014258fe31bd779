#include "server/app/job_places.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

TEST(JobPlaces, FollowTheSimulatorsAndLeaveSomeToPeople) {
  EXPECT_EQ(JobPlaces(4, 1.0, 2), 3);
  EXPECT_EQ(JobPlaces(16, 1.0, 2), 12);
  EXPECT_EQ(JobPlaces(2, 1.0, 64), 1);
}

TEST(JobPlaces, AreNoMoreThanTheCoresCanPlay) {
  EXPECT_EQ(JobPlaces(1000, 0.0, 2), 3);
  EXPECT_EQ(JobPlaces(1000, 1000.0, 2), 3);
  EXPECT_EQ(JobPlaces(1000, 20.0, 2), 20);
  EXPECT_EQ(JobPlaces(10'000, 1.0, 1), 200);
}

TEST(JobPlaces, ALabWithoutSimulatorsStillDiagnoses) {
  EXPECT_EQ(JobPlaces(0, 1.0, 1), 1);
  EXPECT_EQ(JobPlaces(1, 0.0, 1), 1);
}

}  // namespace
}  // namespace faultlab::server
