#pragma once

#include <string>

#include "server/storage/database.h"

namespace faultlab::server {

/// Writers that take the same turn run one after the other, from here to the end of their
/// transactions. Needed for "count, then insert", which PostgreSQL would let two do at once. SQLite
/// has only one writer.
void TakeTurn(Transaction& tx, const std::string& name);

}  // namespace faultlab::server
