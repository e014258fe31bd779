#include "server/storage/turns.h"

#include "server/storage/rows.h"

namespace faultlab::server {

void TakeTurn(Transaction& tx, const std::string& name) {
  if (tx.engine() != Engine::kPostgresql) return;
  Execute(tx, "SELECT pg_advisory_xact_lock(7170282, hashtext(:name))", {{"name", name}});
}

}  // namespace faultlab::server
