#pragma once

#include <map>
#include <string>

#include "server/storage/database.h"

namespace faultlab::tests {

/// "lab_ticket 7" -> column -> value: everything that the lab's tables hold, as text.
using Row = std::map<std::string, std::string>;
using TableDump = std::map<std::string, Row>;

TableDump DumpTables(server::Database& database);
/// The first difference in words; empty when the dumps are equal.
std::string FirstDifference(const TableDump& a, const TableDump& b);

}  // namespace faultlab::tests
