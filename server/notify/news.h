#pragma once

#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::notify {

struct NewsOptions {
  /// How long before its start a booking is recalled. A booking that is made later is not.
  std::vector<std::chrono::minutes> reminders{std::chrono::hours(12), std::chrono::minutes(15)};
  bool mail = false;  ///< this lab sends mail
};

/// Turns what has happened since the last look into messages of the outbox: the lab's own messages
/// (lab_event, whose numbers rise in the order of their commits, because the lab's turns follow
/// each other), alarms, and bookings that begin soon. The messages and how far was read are one
/// transaction; servers that share a database look one after the other. So each cause is found
/// exactly once, whenever a server is killed.
///
/// @returns whether something waits to be sent
core::Result<bool> Gather(Database& database, const NewsOptions& options, WallTime now);

}  // namespace faultlab::server::notify
