#include "server/app/job_places.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

TEST(JobPlaces, FollowTheSimulatorsAndLeaveSomeToPeople) {
  EXPECT_EQ(PlacesForJobs(4, 2).runs, 3);
  EXPECT_EQ(PlacesForJobs(16, 64).runs, 12);
  EXPECT_EQ(PlacesForJobs(2, 64).runs, 1);
}

TEST(JobPlaces, AreNoMoreThanTheCoresCanPlay) {
  EXPECT_EQ(PlacesForJobs(1000, 2).runs, 3);
  EXPECT_EQ(PlacesForJobs(1000, 1).runs, 2);
}

TEST(JobPlaces, ALabWithoutSimulatorsStillDiagnoses) {
  EXPECT_EQ(PlacesForJobs(0, 1).runs, 1);
  EXPECT_EQ(PlacesForJobs(1, 1).runs, 1);
}

}  // namespace
}  // namespace faultlab::server
