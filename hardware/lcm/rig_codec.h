#pragma once

// What rigs, agents and servers tell each other: the types of types/rig_*.lcm and ours.
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/types/fault.h"
#include "faultlab_msgs/fault_t.hpp"
#include "faultlab_msgs/rig_announce_t.hpp"
#include "faultlab_msgs/rig_item_t.hpp"
#include "faultlab_msgs/rig_position_t.hpp"
#include "hardware/lcm/rig_key.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Fields of the lease, the run and the sender are the caller's.
void Encode(const RigDescription& description, faultlab_msgs::rig_announce_t& out);
/// The announcement of this rig, if the key's owner sealed it. Nothing as well when a text that
/// goes on to the lab's pages is not UTF-8 or too long, and of an agent that speaks another
/// protocol.
std::optional<faultlab_msgs::rig_announce_t> ReadAnnouncement(std::span<const std::uint8_t> bytes,
                                                              const std::string& rig,
                                                              const RigKey& key);
/// An announcement that the key's owner made, in a protocol that is not ours.
bool IsForeignProtocol(std::span<const std::uint8_t> bytes,
                       const std::string& rig,
                       const RigKey& key);
/// All but id, kind and bench, which are the receiver's own.
void Decode(const faultlab_msgs::rig_announce_t& in, RigDescription& out);

void Encode(const std::optional<Trip>& trip, faultlab_msgs::rig_announce_t& out);
std::optional<Trip> DecodeTrip(const faultlab_msgs::rig_announce_t& in);

void Encode(const LoopQuality& loop, faultlab_msgs::rig_announce_t& out);
LoopQuality DecodeLoop(const faultlab_msgs::rig_announce_t& in);

std::optional<RigState> ParseRigState(std::string_view name);

faultlab_msgs::rig_item_t ToItem(const RigMessage& message);
/// A kind that this version does not know becomes a kRefused that names it.
RigMessage FromItem(const faultlab_msgs::rig_item_t& item, const core::Bench& bench);

faultlab_msgs::rig_position_t ToPosition(const SelfTestPosition& position);
SelfTestPosition FromPosition(const faultlab_msgs::rig_position_t& in, const core::Bench& bench);

faultlab_msgs::fault_t ToMessage(const core::Fault& fault);
/// Nothing for a component that the bench does not have, or a kind that this version does not know.
std::optional<core::Fault> FromMessage(const faultlab_msgs::fault_t& in, const core::Bench& bench);

}  // namespace faultlab::hardware
