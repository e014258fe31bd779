#pragma once

namespace faultlab::server {

/// How many jobs may run at the same time besides those on rigs that need a session: as many as
/// simulators, but for some that are left to people, and as many as the cores can play.
/// @param speed  of the simulators; 0: as fast as possible
int JobPlaces(int simulators, double speed, int cores);

}  // namespace faultlab::server
