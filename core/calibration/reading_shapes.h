#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// Rows for which one reading is repeated to its last digit before the next comes, as from a slow
/// bus; 1 where each row has its own, or they repeat by chance as those of a coarse counter do.
int HeldRows(std::span<const double> readings);

/// What the readings of a channel tell by themselves about how they were taken, without a model:
/// that they are held for several rows, or stand at an end of a range that the bench does not
/// state. A refusal with what to do, or nothing.
/// What is steady looks alike: asked only of a stretch that does not fit, or leaves too much.
/// @param mask  the channels that are used: bit 0 um, 1 ia, 2 n
std::optional<Error> CheckShapes(const Bench& bench,
                                 std::span<const Sample> samples,
                                 unsigned mask);

}  // namespace faultlab::core
