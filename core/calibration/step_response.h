#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/bench/bench.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// What a record of one or two steps tells of a motor, though it is not rich enough to learn a rig:
/// "step response: gain 56.9 +- 0.1 rpm/V, time constant 64 +- 1 ms". A motor of which one voltage
/// is known while it turns: "step response: it settles at 341 +- 1 rpm under 6 V, time constant
/// ..". Fits n = gain uc + constant, behind one time constant, to the whole record; errors allow
/// for the correlation of what is left. Nothing where n is not measured, does not move, or is not
/// of first order.
/// Cost: 100 fits of at most 10 000 rows.
std::optional<std::string> StepResponseText(std::span<const Sample> samples,
                                            const Bench& bench,
                                            double period_s);

}  // namespace faultlab::core
