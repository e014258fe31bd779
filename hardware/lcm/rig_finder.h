#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// How well we hear a far rig.
enum class LinkState {
  kBack,  ///< heard within the last 500 ms
  kLate,  ///< silent for more than 500 ms
  kLost,  ///< silent for more than 2 s
};
std::string_view Name(LinkState state);  ///< "back", "late", "lost"

/// Why this server cannot use a rig that it hears.
enum class RigRefusal {
  kHeldElsewhere,    ///< another lab has the lease
  kNoKey,            ///< its key is not here
  kOtherKey,         ///< its messages are not made with the key that is here
  kOtherProtocol,    ///< its agent and this server are of versions that do not go together
  kBenchUnreadable,  ///< the description of its bench is refused
  kBenchAwaited,     ///< the description of its bench has not come yet
};
/// "held_elsewhere", "no_key", "other_key", "other_protocol", "bench_unreadable", "bench_awaited".
std::string_view Name(RigRefusal refusal);
/// One sentence for a person, with what to do.
/// @param detail  the holder of kHeldElsewhere, the error of kBenchUnreadable
std::string RefusalText(RigRefusal refusal, const std::string& detail = {});

/// What a far rig says about itself, and we about the way to it.
struct RemoteRigInfo {
  RigDescription description;
  RigKind behind = RigKind::kBench;  ///< what the agent drives: bench or simulated
  RigState state = RigState::kOffline;
  LinkState link = LinkState::kLost;
  double silent_s = 0.0;     ///< since it was heard last
  std::optional<Trip> trip;  ///< the interlock that holds it
  std::string holder;        ///< who leases it, LAB/MEMBER; empty = nobody
  bool held_by_us = false;
  bool key_known = false;                ///< without its key it is a name that anybody can say
  std::string calibration;               ///< date and version, as the agent has it
  std::optional<double> clock_offset_s;  ///< agent's unix time minus ours, while we lease it
  double round_trip_s = 0.0;
  std::int64_t gaps_refilled = 0;  ///< messages of runs that came by refill
  LoopQuality loop;                ///< of the agent's loop, since the agent started
  /// The highest that the agent has seen, by an announcement with its key.
  std::optional<Epoch> epoch;
  /// Why this server cannot use it though it may be heard; nothing: it can.
  std::optional<RigRefusal> refusal;
  std::string refusal_text;  ///< the same for a person, with what to do; empty: it can
};

struct RigFinderOptions {
  std::string lcm_url;
  std::string key_directory;  ///< ID.key files; empty: $HOME/.faultlab/keys
  /// Of all servers that share one database and so its epochs, and of no other. Empty: this server
  /// is a lab of its own until it ends.
  std::string lab;
  std::string server_name;  ///< shown to other servers in the holder's name
};

/// Finds the agents on a bus by itself and makes a Rig of each. Thread-safe; own thread.
class RigFinder {
 public:
  virtual ~RigFinder() = default;
  /// Every rig ever heard whose key and description are here, by id: what it says is proved by its
  /// key. A rig that comes back with another description is another object.
  virtual std::vector<RemoteRigInfo> List() const = 0;
  /// Names heard in the last minute without such a proof, at most 64, and rigs without a
  /// description that can be read: for operators, who may copy the key or mend the file. Nothing is
  /// known of them but the name, the silence and the refusal.
  virtual std::vector<RemoteRigInfo> Unkeyed() const = 0;
  /// A Rig (kind kRemote) like any other: its first use leases it, the end of the finder gives it
  /// back.
  /// Null for an id never heard, or without its key or description.
  virtual std::shared_ptr<Rig> Find(const std::string& id) = 0;
};

/// kUnavailable when the bus does not open.
core::Result<std::unique_ptr<RigFinder>> OpenRigFinder(const RigFinderOptions& options);

}  // namespace faultlab::hardware
