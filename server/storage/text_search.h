#pragma once

#include <string>

#include "server/storage/database.h"

namespace faultlab::server {

/// SQL that is true where the text `searched` contains the bound text :name, whatever the case of
/// its letters. Not LIKE: with a pattern of many equal letters that takes the product of both
/// lengths.
inline std::string ContainsSql(const Transaction& tx,
                               const std::string& searched,
                               const std::string& name) {
  const std::string position = tx.engine() == Engine::kSqlite ? "INSTR" : "STRPOS";
  return position + "(" + searched + ", LOWER(:" + name + ")) > 0";
}

}  // namespace faultlab::server
