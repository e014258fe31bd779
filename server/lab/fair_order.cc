#include "server/lab/fair_order.h"

#include <algorithm>
#include <cmath>

namespace faultlab::server::lab {
namespace {

double Seconds(Milliseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

double DecayedUse(const Usage& usage, WallTime now, const Policy& policy) {
  const double age_s = std::max(0.0, Seconds(now - usage.at));
  return usage.seconds * std::exp2(-age_s / Seconds(policy.half_life));
}

double FairScore(const Ticket& ticket, double decayed_use_s, WallTime now, const Policy& policy) {
  const double age_s = Seconds(now - ticket.created);
  return policy.age_weight_per_s * age_s +
         policy.fresh_user_bonus_s * std::exp2(-decayed_use_s / policy.use_quota_s) + ticket.weight;
}

std::vector<TicketId> QueueOrder(const LabState& state,
                                 const std::string& rig_class,
                                 WallTime now,
                                 const Policy& policy) {
  std::vector<std::pair<double, TicketId>> scored;
  for (const auto& [id, ticket] : state.tickets) {
    if (ticket.state != TicketState::kWaiting || ticket.rig_class != rig_class) continue;
    const auto used = state.usage.find(ticket.user);
    const double use_s = used == state.usage.end() ? 0.0 : DecayedUse(used->second, now, policy);
    scored.emplace_back(-FairScore(ticket, use_s, now, policy), id);
  }
  std::sort(scored.begin(), scored.end());
  std::vector<TicketId> order;
  order.reserve(scored.size());
  for (const auto& entry : scored) order.push_back(entry.second);
  return order;
}

}  // namespace faultlab::server::lab
