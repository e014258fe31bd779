#pragma once

namespace faultlab::server {

/// How many jobs may be in progress at the same time, besides those on rigs that need a session.
struct JobPlaces {
  int runs = 1;       ///< on simulators
  int computing = 2;  ///< diagnoses, and methods that are compared

  /// The most of `places` that one owner may have: the last one is kept for somebody else.
  static int ShareOf(int places);
};

/// As many runs as simulators, but for some that are left to people; of these, which are played as
/// fast as a core can, and of what computes, one more than there are cores.
JobPlaces PlacesForJobs(int simulators, int cores);

}  // namespace faultlab::server
