#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "faultlab_msgs/rig_announce_t.hpp"
#include "hardware/bounded_queue.h"
#include "hardware/clock.h"
#include "hardware/lcm/agent_client.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/reorder_buffer.h"
#include "hardware/lcm/rig_finder.h"
#include "hardware/lcm/rig_key.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

struct RemoteRigSettings {
  std::string holder;  ///< our name, HolderName; its member is unique to this start
  RigKey key{};
  Nanoseconds retry = std::chrono::milliseconds(100);
  Nanoseconds give_up = std::chrono::seconds(2);  ///< of one request
  /// A run whose rig stays silent this long is over.
  Nanoseconds lost_for_good = std::chrono::seconds(90);
  std::size_t queue_messages = 1u << 16;
};

/// A far rig as a Rig: leases it, uploads the plan, puts its stream in order, asks again for what
/// was lost. Rig's calls come from any thread; the On..s and Poll from the bus thread, which they
/// never wait for.
///
///   Arm -> "lease" of its epoch -> "plan".. -> "arm"                  each asked until answered
///   Fence -> "lease" of the new epoch, by Poll until it is answered: ends the older run there
///   stream -> ReorderBuffer -> queue -> Read;  hole -> "refill" until it is closed
///
/// The first use makes the rig ours: the lease is kept between runs, until this object ends or the
/// agent gives the rig to somebody else.
class RemoteRig final : public Rig {
 public:
  RemoteRig(std::string id,
            std::shared_ptr<MessageBus> bus,
            RemoteRigSettings settings,
            std::function<Nanoseconds()> now,
            std::function<std::int64_t()> unix_ns);
  ~RemoteRig() override;

  const RigDescription& description() const override { return description_; }
  RigState state() const override;
  core::Status Arm(RunPlan plan, Epoch epoch) override;
  core::Status Start(Epoch epoch) override;
  core::Status Command(Epoch epoch, const RigCommand& command) override;
  void KeepAlive(Epoch epoch) override;
  ReadStatus Read(std::vector<RigMessage>& out, std::chrono::milliseconds patience) override;
  void Fence(Epoch epoch) override;
  void SafeStop(std::string_view reason) override;
  core::Result<SelfTestReport> SelfTest(Epoch epoch) override;
  std::optional<Trip> trip() const override;
  LoopQuality loop_quality() const override;
  std::optional<std::chrono::nanoseconds> silence() const override;
  /// The agent's start and its number of the run.
  std::string kept_run() const override;
  core::Status Resume(const std::string& kept_run) override;

  RemoteRigInfo info() const;
  const RigKey& key() const { return settings_.key; }
  /// The announced bench is known: nothing may be asked of description() before.
  bool IsDescribed() const;
  /// The agent came back as another bench: this object is of no more use.
  bool AnnouncesAnotherBench() const;
  /// Why the description that came last cannot be read; empty: it can, or none came.
  std::string bench_refusal() const;

  /// Its agent has another key now: a run ends, and this object is of no more use.
  void GiveUp(const std::string& reason);

  /// Messages of this rig, as the bus gives them.
  /// @returns false when the owner of this rig's key did not make it
  bool OnAnnounce(MessageBus::Bytes bytes);
  void OnBench(MessageBus::Bytes bytes);
  void OnReply(MessageBus::Bytes bytes);
  void OnStream(MessageBus::Bytes bytes);
  /// Keepalive, refill, lost rigs. Every few milliseconds.
  void Poll();

 private:
  core::Status Lease(Epoch epoch);
  core::Status Upload(const RunPlan& plan, Epoch epoch, std::int64_t& run);
  core::Result<AgentClient::Reply> Ask(AgentClient::Message message);
  LinkState Link() const;
  std::optional<RigRefusal> Refusal() const;
  void TakeDescription(const faultlab_msgs::rig_announce_t& said);
  void FollowTrip(const RigEvent& event);
  void Deliver(std::vector<RigMessage> messages);
  void EndRun(RigMessage last);
  void EndRun(const std::string& reason);

  const std::string id_;
  const std::string stream_channel_;
  const RemoteRigSettings settings_;
  const std::function<Nanoseconds()> now_;
  AgentClient line_;

  std::mutex control_mutex_;  ///< one Arm, Start or self-test at a time; taken before mutex_
  mutable std::mutex mutex_;  ///< taken before the line's own
  std::condition_variable run_ended_;
  RigDescription description_;
  bool described_ = false;
  std::string bench_refusal_;  ///< of the description that came last; empty: it was read
  std::optional<faultlab_msgs::rig_announce_t> announced_;
  Nanoseconds heard_at_{-1};
  bool foreign_protocol_ = false;  ///< of the last announcement
  bool other_key_ = false;         ///< the last one of this name was not made with our key

  Nanoseconds holder_word_at_{-1};
  std::atomic<int> readers_{0};
  Nanoseconds alive_sent_at_{-1};

  RigState run_state_ = RigState::kIdle;
  ReorderBuffer assembly_;
  Nanoseconds refill_asked_at_{-1};
  BoundedQueue<RigMessage> queue_;
};

}  // namespace faultlab::hardware
