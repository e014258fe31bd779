#pragma once

#include <string>

#include "server/storage/database.h"

namespace faultlab::server {

/// Writers that take the same turn go one after the other, from here to the end of their
/// transactions: for "count, then insert", which PostgreSQL would let two do at once. SQLite has
/// one writer.
void TakeTurn(Transaction& tx, const std::string& name);

}  // namespace faultlab::server
