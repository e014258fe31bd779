#include "server/lab/fair_order.h"

#include <algorithm>
#include <cmath>
#include <tuple>

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

bool KeepsPlace(const Ticket& ticket, WallTime now, const Policy& policy) {
  return ticket.kind == TicketKind::kPerson && ticket.first_expected &&
         now - ticket.created >= policy.asked_together &&
         *ticket.first_expected <= now + policy.keeps_place;
}

std::vector<TicketId> QueueOrder(const LabState& state,
                                 const std::string& rig_class,
                                 WallTime now,
                                 const Policy& policy) {
  std::vector<std::tuple<bool, WallTime, double, TicketId>> ranked;
  for (const auto& [id, ticket] : state.tickets) {
    if (ticket.state != TicketState::kWaiting || ticket.rig_class != rig_class) continue;
    if (KeepsPlace(ticket, now, policy)) {
      ranked.emplace_back(false, *ticket.first_expected, 0.0, id);
      continue;
    }
    const auto used = state.usage.find(ticket.user);
    const double use_s = used == state.usage.end() ? 0.0 : DecayedUse(used->second, now, policy);
    ranked.emplace_back(true, WallTime{}, -FairScore(ticket, use_s, now, policy), id);
  }
  std::ranges::sort(ranked);
  std::vector<TicketId> order;
  order.reserve(ranked.size());
  for (const auto& entry : ranked) order.push_back(std::get<TicketId>(entry));
  return order;
}

}  // namespace faultlab::server::lab
