#pragma once

#include <optional>

#include "core/bench/bench.h"
#include "core/control/control_order.h"
#include "faultlab_msgs/rig_order_t.hpp"
#include "faultlab_msgs/rig_reference_t.hpp"
#include "hardware/run_plan.h"

namespace faultlab::hardware {

faultlab_msgs::rig_reference_t ToMessage(const SpeedControlPlan& plan);
/// Nothing for words that this version does not know.
std::optional<SpeedControlPlan> FromMessage(const faultlab_msgs::rig_reference_t& in);

faultlab_msgs::rig_order_t ToMessage(const core::ControlOrder& order);
/// Nothing for a component that the bench does not have.
std::optional<core::ControlOrder> FromMessage(const faultlab_msgs::rig_order_t& in,
                                              const core::Bench& bench);

}  // namespace faultlab::hardware
