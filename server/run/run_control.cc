// What the diagnosis of a run tells the drive of its rig.
#include <memory>

#include "core/control/closed_loop/orders.h"
#include "server/run/run.h"

namespace faultlab::server {

/// After each sample: a new verdict is a new order. Without a learnt rig there is none, and the rig
/// goes on with its plan's uc.
void Run::FollowControl() {
  if (learning_ != core::Learning::kLearnt) return;
  if (ordered_ == pipeline_.verdict_version()) return;
  hardware::RigCommand command{.kind = hardware::RigCommand::Kind::kControl};
  command.control = core::OrderOf(*request_.diagnosis.bench,
                                  *pipeline_.calibration(),
                                  pipeline_.verdict(),
                                  request_.diagnosis.period_s);
  if (!real_time_) {
    Order(command);
    ordered_ = pipeline_.verdict_version();
    return;
  }
  // A rig may answer slowly. When too much waits already, the next sample tries again.
  const bool sent = services_.commands.Submit([weak = weak_from_this(), command] {
    if (const std::shared_ptr<Run> run = weak.lock()) run->Order(command);
  });
  if (sent) ordered_ = pipeline_.verdict_version();
}

void Run::Order(const hardware::RigCommand& command) {
  const std::lock_guard lock(control_mutex_);
  if (!rig_is_ours_) return;
  const core::Status taken = rig_->Command(epoch_, command);
  if (!taken.ok()) services_.log("run " + id_ + ": speed control: " + taken.error().message);
}

}  // namespace faultlab::server
