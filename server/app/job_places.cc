#include "server/app/job_places.h"

#include <algorithm>

namespace faultlab::server {
namespace {

/// A core plays so many seconds of runs in one second, with their diagnosis and recording.
constexpr double kPlayedByACore = 200.0;
/// One job computes while another waits for the disk.
constexpr int kWaitForTheDisk = 1;

}  // namespace

int JobPlaces::ShareOf(int places) {
  return std::max(1, places - 1);
}

JobPlaces PlacesForJobs(int simulators, double speed, int cores) {
  const int left_to_people = std::max(1, simulators / 4);
  const int computing = cores + kWaitForTheDisk;
  int playing = computing;
  if (speed > 0.0) {
    const double played = static_cast<double>(cores) * kPlayedByACore / speed;
    playing = std::max(computing, static_cast<int>(std::min(played, 10'000.0)));
  }
  return {std::max(1, std::min(simulators - left_to_people, playing)), computing};
}

}  // namespace faultlab::server
