#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hardware/rig.h"
#include "server/lab/lease.h"

namespace faultlab::server::lab::rehearsal {

/// Time since the start of the world, the same for everybody.
using WorldTime = Milliseconds;

/// Who sends what the rig gets now, set by the world around each call.
struct Sender {
  UserId user{};
  std::string member;
  WorldTime sent{};
  std::int64_t after = 0;  ///< this many answers of any server
};

/// The body of a rig: what stands on the table. Keeps the highest epoch that it has seen, refuses
/// what is older, and reports what it accepts.
class RigBody {
 public:
  using Report = std::function<void(const RigId& rig, std::uint64_t epoch)>;
  RigBody(RigId id, Report accepted) : id_(std::move(id)), accepted_(std::move(accepted)) {}

  /// A request with a lease: kStale when the rig has seen a newer one.
  core::Status Accept(std::uint64_t epoch);
  /// A newer lease exists: the run of an older one is stopped.
  void Fence(std::uint64_t epoch);
  void Run(bool running) { running_ = running; }
  /// False: its link is out; it plays on.
  void Answer(bool answers) { answers_ = answers; }
  bool answers() const { return answers_; }
  bool running() const { return running_; }
  std::uint64_t epoch() const { return fence_.epoch(); }

 private:
  const RigId id_;
  const Report accepted_;
  lab::Fence fence_;
  bool running_ = false;
  bool answers_ = true;
};

/// A message on its way to a far rig.
struct InFlight {
  WorldTime arrives{};
  std::uint64_t epoch = 0;
  bool fence = false;  ///< otherwise a command
  Sender sender;
};

/// What happens to a message to a far rig. nullopt: it is lost.
using Way = std::function<std::optional<WorldTime>()>;

/// A server's hold of a rig body. Of a rig beside the server it acts at once; of a far one,
/// messages take their way and may be lost, and the request for a lease waits for its answer.
class RehearsedRig : public hardware::Rig {
 public:
  /// Beside the server.
  RehearsedRig(hardware::RigDescription description, std::shared_ptr<RigBody> body);
  /// Far. The messages wait in `line` until the world delivers them.
  RehearsedRig(hardware::RigDescription description,
               std::shared_ptr<RigBody> body,
               std::shared_ptr<std::deque<InFlight>> line,
               const Sender& sender,
               Way way);

  const hardware::RigDescription& description() const override { return description_; }
  hardware::RigState state() const override {
    if (!body_->answers()) return hardware::RigState::kOffline;
    return body_->running() ? hardware::RigState::kRunning : hardware::RigState::kIdle;
  }
  core::Status Arm(hardware::RunPlan plan, hardware::Epoch epoch) override;
  core::Status Start(hardware::Epoch epoch) override;
  core::Status Command(hardware::Epoch epoch, const hardware::RigCommand& command) override;
  void KeepAlive(hardware::Epoch) override {}
  hardware::ReadStatus Read(std::vector<hardware::RigMessage>&,
                            std::chrono::milliseconds) override {
    return hardware::ReadStatus::kEnded;
  }
  void Fence(hardware::Epoch epoch) override;
  void SafeStop(std::string_view) override {
    if (body_->epoch() == armed_) body_->Run(false);
  }
  core::Result<hardware::SelfTestReport> SelfTest(hardware::Epoch) override {
    return hardware::SelfTestReport{};
  }
  std::optional<hardware::Trip> trip() const override { return std::nullopt; }
  hardware::LoopQuality loop_quality() const override { return {}; }

 private:
  const hardware::RigDescription description_;
  const std::shared_ptr<RigBody> body_;
  const std::shared_ptr<std::deque<InFlight>> line_;  ///< null: beside the server
  const Sender* const sender_ = nullptr;
  const Way way_;
  std::uint64_t armed_ = 0;
  lab::Fence fence_;  ///< far
};

}  // namespace faultlab::server::lab::rehearsal
