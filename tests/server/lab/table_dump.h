#pragma once

#include <map>
#include <string>

#include "server/storage/database.h"

namespace faultlab::tests {

/// "lab_ticket 7" -> column -> value: the contents of the lab's tables, as text.
using Row = std::map<std::string, std::string>;
using TableDump = std::map<std::string, Row>;

TableDump DumpTables(server::Database& database);
/// A description of the first difference; empty when the dumps are equal.
std::string FirstDifference(const TableDump& a, const TableDump& b);

}  // namespace faultlab::tests
