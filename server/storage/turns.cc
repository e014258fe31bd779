#include "server/storage/turns.h"

#include <soci/soci.h>

namespace faultlab::server {

void TakeTurn(Transaction& tx, const std::string& name) {
  if (tx.engine() != Engine::kPostgresql) return;
  tx.sql() << "SELECT pg_advisory_xact_lock(7170282, hashtext(:name))", soci::use(name, "name");
}

}  // namespace faultlab::server
