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

/// Whether other tickets no longer overtake this one: it is a person's, it was not made just now
/// (policy.asked_together), and its first estimate is at most policy.keeps_place ahead. So the
/// first estimate stays true.
bool KeepsPlace(const Ticket& ticket, WallTime now, const Policy& policy);

/// The waiting tickets of a class in the order of service: those that keep their place, by their
/// first estimate; then the others, by their score.
std::vector<TicketId> QueueOrder(const LabState& state,
                                 const std::string& rig_class,
                                 WallTime now,
                                 const Policy& policy);

}  // namespace faultlab::server::lab
