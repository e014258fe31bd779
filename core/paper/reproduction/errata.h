#pragma once

#include <optional>
#include <string>

#include "core/paper/reproduction/table_row.h"

namespace faultlab::core {

/// Why a printed number of the paper should not be trusted; empty if no error is known.
/// @param table  3..20;  @param name  of the row, see TableRow
/// The list and its reasons: core/README.md, "Errata of the paper".
std::string ErratumOf(int table, const std::optional<TableFault>& fault, const std::string& name);

}  // namespace faultlab::core
