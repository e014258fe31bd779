#include "server/net/connection_host.h"

#include "server/net/connection.h"

namespace faultlab::server {
namespace {

/// Whose bytes are worth most to the others.
Connection* MostHolding(const std::unordered_set<Connection*>& connections,
                        const Connection& asker) {
  std::unordered_map<std::string_view, std::size_t> held;
  for (const Connection* connection : connections) {
    if (connection->held_bytes() == 0) continue;
    held[connection->caller()] += connection->held_bytes();
  }
  const std::size_t of_asker = held[asker.caller()];
  Connection* victim = nullptr;
  for (Connection* connection : connections) {
    if (connection->held_bytes() == 0 || !connection->waits_for_client()) continue;
    const std::size_t of_caller = held[connection->caller()];
    if (of_caller < of_asker || connection->caller() == asker.caller()) continue;
    if (victim != nullptr) {
      const std::size_t most = held[victim->caller()];
      const bool longer = connection->waits_since() < victim->waits_since();
      if (of_caller < most || (of_caller == most && !longer)) continue;
    }
    victim = connection;
  }
  return victim;
}

}  // namespace

std::optional<ByteBudget::Hold> ConnectionHost::TakeBytes(std::size_t bytes,
                                                          const Connection& asker) {
  while (true) {
    if (auto hold = waiting_bytes.Take(bytes)) return hold;
    Connection* const victim = MostHolding(connections, asker);
    if (victim == nullptr) return std::nullopt;
    ++counters.bytes_refused;
    victim->GiveUp();
  }
}

}  // namespace faultlab::server
