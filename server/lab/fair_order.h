#pragma once

#include <string>
#include <vector>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

/// Past use in seconds at `now`: halves every policy.half_life.
double DecayedUse(const Usage& usage, WallTime now, const Policy& policy);

/// score = age_weight * age_s + fresh_user_bonus_s * 2^(-use / use_quota) + weight
/// The highest score goes first, equal scores by id. Age has no limit, so every ticket gets to the
/// front.
double FairScore(const Ticket& ticket, double decayed_use_s, WallTime now, const Policy& policy);

/// The waiting tickets of a class in the order of service.
std::vector<TicketId> QueueOrder(const LabState& state,
                                 const std::string& rig_class,
                                 WallTime now,
                                 const Policy& policy);

}  // namespace faultlab::server::lab
