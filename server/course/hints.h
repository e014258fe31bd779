#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>

#include "core/diagnosis/diagnosis.h"

namespace faultlab::server::course {

/// How many parts the second hint leaves.
inline constexpr std::size_t kHintParts = 3;
inline constexpr int kHintsMax = 2;

/// What the lab's own diagnosis of the record says, little by little, for points
/// (Rubric::hint_percent): nothing of it is known from the truth.
/// - 0: {"kind": "when", "at_s": N or null}: when the lab noticed something
/// - 1: {"kind": "parts", "components": [..]}: the most likely ones, by name
boost::json::object HintOf(int number, const core::Diagnosis& diagnosis);

}  // namespace faultlab::server::course
