#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "faultlab_msgs/rig_command_t.hpp"
#include "faultlab_msgs/rig_reply_t.hpp"
#include "hardware/clock.h"
#include "hardware/holder_silence.h"
#include "hardware/lcm/command_authenticator.h"
#include "hardware/lcm/epoch_file.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/received_plan.h"
#include "hardware/lcm/retransmit_buffer.h"
#include "hardware/lcm/rig_key.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

struct RigAgentSettings {
  RigKey key{};
  std::string calibration;  ///< told to whoever listens
  /// Takes a line for the log: how each run began and ended.
  std::function<void(const std::string&)> say = [](const std::string&) {};
  /// Silence of the lease holder after which a run is stopped.
  Nanoseconds watchdog = kHolderSilence;
  /// Length of a lease; each word of its holder renews it. Longer than the watchdog.
  Nanoseconds lease = std::chrono::seconds(5);
  std::size_t ring_items =
      1u << 14;  ///< of a run, kept for refills: 160 s at 100 Hz, 16 s at 1 kHz
};

/// What was refused, by reason; for /metrics and tests.
struct RigAgentCounts {
  std::uint64_t accepted = 0;
  std::uint64_t forged = 0;    ///< no message, or not with the rig's key
  std::uint64_t replayed = 0;  ///< counter not above the last, or for another boot
  std::uint64_t stale = 0;     ///< of another epoch, a lease of an older one
  std::uint64_t not_holder = 0;
  std::uint64_t stream_messages = 0;
  std::uint64_t stream_bytes = 0;
  std::uint64_t refill_messages = 0;  ///< of the stream messages
};

/// The bench's side of a remote rig: obeys the lease holder, streams the run, keeps it in a ring.
///
///   command -> CommandAuthenticator (key, boot, counter) -> lease and epoch? -> rig -> reply
///   rig.Read -> RetransmitBuffer -> stream;  "refill" -> stream from the ring
///
/// The agent makes no epochs. It takes the lease of a higher epoch than the highest it has seen,
/// and that one again from the lab that had it; a lower one never, not after a restart either
/// (EpochFile). A living holder gives way to a higher epoch of its own lab alone: others wait until
/// it has been silent for the length of a lease. One thread: Poll, which the handlers of the bus
/// run in, too.
class RigAgent {
 public:
  RigAgent(Rig& rig,
           MessageBus& bus,
           RigAgentSettings settings,
           EpochFile epochs,
           std::function<Nanoseconds()> now,
           std::function<std::int64_t()> unix_ns);
  ~RigAgent();

  /// Streams what the rig said, announces, minds lease and watchdog. Every few milliseconds.
  void Poll();
  /// What the bus heard on FAULTLAB.<rig>.COMMAND; subscribed by the constructor.
  void OnCommand(MessageBus::Bytes bytes);

  const RigAgentCounts& counts() const { return counts_; }
  /// The highest that was ever seen.
  Epoch epoch() const { return Epoch{epochs_.seen().epoch}; }
  std::int64_t boot() const { return boot_; }

 private:
  using Command = faultlab_msgs::rig_command_t;
  using Reply = faultlab_msgs::rig_reply_t;

  bool Leased() const { return !holder_.empty() && now_() < lease_until_; }
  void EndLease(std::string_view reason);
  std::optional<core::Error> RefuseLease(const Command& command) const;
  Reply Answer(const Command& command, std::int64_t received_ns);
  void Obey(const Command& command, Reply& reply);
  void Lease(const Command& command, Reply& reply);
  void Arm(const Command& command, Reply& reply);
  void Refill(std::int64_t from, std::int64_t to);
  void Order(const Command& command, Reply& reply);
  void SelfTest(Reply& reply);
  void Send(Reply reply);
  void Log(const RigEvent& event) const;
  void StreamRun();
  void PublishPieces(std::int64_t from, std::int64_t to);
  void Publish(faultlab_msgs::rig_stream_t piece);
  void Announce();
  void Describe();

  Rig& rig_;
  MessageBus& bus_;
  const RigAgentSettings settings_;
  const std::function<Nanoseconds()> now_;
  const std::function<std::int64_t()> unix_ns_;
  const std::string id_;
  const std::string reply_channel_;
  const std::string stream_channel_;
  const std::int64_t boot_;

  EpochFile epochs_;
  std::string holder_;  ///< of the lease of epoch(); empty = nobody
  Nanoseconds lease_until_{0};
  Nanoseconds heard_at_{0};
  CommandAuthenticator gate_;

  ReceivedPlan plan_;
  std::int64_t run_ = 0;
  RetransmitBuffer ring_;
  std::int64_t streamed_seq_ = 0;  ///< the first of the run that was not streamed yet
  std::int64_t announce_seq_ = 0;
  Nanoseconds announced_at_{-1};
  RigState announced_state_ = RigState::kOffline;
  std::vector<RigMessage> messages_;
  RigAgentCounts counts_;
};

}  // namespace faultlab::hardware
