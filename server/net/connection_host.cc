#include "server/net/connection_host.h"

#include <tuple>

#include "server/net/connection.h"

namespace faultlab::server {
namespace {

/// The connection to close for `bytes` more of the asker's. Connections without an account are
/// chosen first, then those of the caller who holds most, then the one that has waited longest. An
/// asker with an account may close any connection without one, an asker without an account none
/// with one; within one kind, only connections of a caller who holds more than the asker would.
Connection* WhoGivesWay(const std::unordered_set<Connection*>& connections,
                        const Connection& asker,
                        std::size_t bytes) {
  std::unordered_map<std::string_view, std::size_t> held;
  for (const Connection* connection : connections) {
    if (connection->held_bytes() == 0) continue;
    held[connection->caller()] += connection->held_bytes();
  }
  const std::size_t of_asker = held[asker.caller()] + bytes;
  Connection* victim = nullptr;
  std::tuple<bool, std::size_t, std::chrono::steady_clock::duration> worst;
  for (Connection* connection : connections) {
    if (connection->held_bytes() == 0 || !connection->waits_for_client()) continue;
    if (connection->caller() == asker.caller()) continue;
    const bool stranger = !connection->caller_is_known();
    if (!stranger && !asker.caller_is_known()) continue;
    const std::size_t of_caller = held[connection->caller()];
    const bool to_an_account = stranger && asker.caller_is_known();
    if (!to_an_account && of_caller < of_asker) continue;
    const std::tuple rank(stranger, of_caller, -connection->waits_since().time_since_epoch());
    if (victim != nullptr && rank <= worst) continue;
    victim = connection;
    worst = rank;
  }
  return victim;
}

}  // namespace

std::optional<ByteBudget::Reservation> ConnectionHost::TakeBytes(std::size_t bytes,
                                                                 const Connection& asker) {
  while (true) {
    if (auto hold = waiting_bytes.Take(bytes)) return hold;
    Connection* const victim = WhoGivesWay(connections, asker, bytes);
    if (victim == nullptr) return std::nullopt;
    ++counters.bytes_refused;
    victim->GiveUp();
  }
}

}  // namespace faultlab::server
