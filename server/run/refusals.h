#pragma once

#include <string>
#include <string_view>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "hardware/lcm/rig_finder.h"

// Refusals of several places that core::Refuse alone does not make.
namespace faultlab::server::refusal {

/// Nobody can use the rig, which this server hears: RigRefusal is the reason.
core::Error RigRefused(const std::string& rig, const hardware::RemoteRigInfo& why);
/// The rig does not take the lease: the error of its Arm, with a reason: another lab has it, or
/// what the rig says is in its message alone.
core::Error OfLease(const std::string& rig, core::Error error);
/// @param symbol  that `bench` does not have
core::Error NoComponent(const core::Bench& bench, std::string_view symbol);

/// The refusal for a part of a request: its field becomes `field`.
core::Error At(core::Error error, std::string field);
/// What a part of a request names is refused, so the request is invalid: as At, with kInvalid.
core::Error In(core::Error error, std::string field);

}  // namespace faultlab::server::refusal
