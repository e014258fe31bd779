#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hardware/rig.h"
#include "server/run/rig_tally.h"

namespace faultlab::server {

/// A rig whose relay closings, trips and straying delta go into a tally as its holder reads them:
/// runs, checks and self-tests are all counted here. Relays are counted of rigs that have them
/// (`!any_value`): a confirmed position is one closing of its line, and the return to nominal at
/// the end of a run is one of the nominal line.
class TalliedRig : public hardware::Rig {
 public:
  TalliedRig(std::shared_ptr<hardware::Rig> rig, std::shared_ptr<RigTally> tally);

  const hardware::RigDescription& description() const override { return rig_->description(); }
  hardware::RigState state() const override { return rig_->state(); }
  core::Status Arm(hardware::RunPlan plan, hardware::Epoch epoch) override;
  core::Status Start(hardware::Epoch epoch) override { return rig_->Start(epoch); }
  core::Status Command(hardware::Epoch epoch, const hardware::RigCommand& command) override {
    return rig_->Command(epoch, command);
  }
  void KeepAlive(hardware::Epoch epoch) override { rig_->KeepAlive(epoch); }
  hardware::ReadStatus Read(std::vector<hardware::RigMessage>& out,
                            std::chrono::milliseconds patience) override;
  void Fence(hardware::Epoch epoch) override { rig_->Fence(epoch); }
  void SafeStop(std::string_view reason) override;
  core::Result<hardware::SelfTestReport> SelfTest(hardware::Epoch epoch) override;
  std::optional<hardware::Trip> trip() const override { return rig_->trip(); }
  hardware::LoopQuality loop_quality() const override { return rig_->loop_quality(); }
  std::optional<std::chrono::nanoseconds> silence() const override { return rig_->silence(); }
  std::string kept_run() const override { return rig_->kept_run(); }
  core::Status Resume(const std::string& kept_run) override { return rig_->Resume(kept_run); }

 private:
  void Note(const hardware::RigEvent& event);
  void MoveTo(core::Component component, int position);
  void ReturnToNominal();
  const std::string& id() const { return rig_->description().id; }

  const std::shared_ptr<hardware::Rig> rig_;
  const std::shared_ptr<RigTally> tally_;
  std::mutex mutex_;
  std::map<int, int> position_;  ///< by index of the component; absent: nominal
};

}  // namespace faultlab::server
