#include "server/app/job_places.h"

#include <algorithm>

namespace faultlab::server {
namespace {

/// One job computes or plays while another waits for the disk.
constexpr int kWaitForTheDisk = 1;

}  // namespace

int JobPlaces::ShareOf(int places) {
  return std::max(1, places - 1);
}

JobPlaces PlacesForJobs(int simulators, int cores) {
  const int left_to_people = std::max(1, simulators / 4);
  const int at_once = cores + kWaitForTheDisk;
  return {std::max(1, std::min(simulators - left_to_people, at_once)), at_once};
}

}  // namespace faultlab::server
