#include "server/app/job_places.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

TEST(JobPlaces, FollowTheSimulatorsAndLeaveSomeToPeople) {
  EXPECT_EQ(PlacesForJobs(4, 1.0, 2).runs, 3);
  EXPECT_EQ(PlacesForJobs(16, 1.0, 2).runs, 12);
  EXPECT_EQ(PlacesForJobs(2, 1.0, 64).runs, 1);
}

TEST(JobPlaces, AreNoMoreThanTheCoresCanPlay) {
  EXPECT_EQ(PlacesForJobs(1000, 0.0, 2).runs, 3);
  EXPECT_EQ(PlacesForJobs(1000, 1000.0, 2).runs, 3);
  EXPECT_EQ(PlacesForJobs(1000, 20.0, 2).runs, 20);
  EXPECT_EQ(PlacesForJobs(10'000, 1.0, 1).runs, 200);
}

TEST(JobPlaces, ALabWithoutSimulatorsStillDiagnoses) {
  EXPECT_EQ(PlacesForJobs(0, 1.0, 1).runs, 1);
  EXPECT_EQ(PlacesForJobs(1, 0.0, 1).runs, 1);
}

}  // namespace
}  // namespace faultlab::server
