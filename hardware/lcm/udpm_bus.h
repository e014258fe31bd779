#pragma once

#include <memory>

#include "core/types/result.h"
#include "hardware/lcm/bus_url.h"
#include "hardware/lcm/message_bus.h"

namespace faultlab::hardware {

/// LCM over UDP multicast, on sockets of our own: liblcm's reader can be crashed by one datagram.
/// kUnavailable, with the system's words, when the group cannot be joined.
core::Result<std::unique_ptr<MessageBus>> OpenUdpmBus(const UdpmUrl& url);

}  // namespace faultlab::hardware
