#pragma once

#include <span>
#include <string_view>

#include "core/types/structure.h"

namespace faultlab::core {

/// All kinds of benches that are compiled in. A new kind is one more folder here and one row in the
/// list.
std::span<const Structure* const> Structures();
/// nullptr when no structure has this name.
const Structure* FindStructure(std::string_view name);

}  // namespace faultlab::core
