#include "tests/world/rehearsed_rig.h"

#include <algorithm>
#include <utility>

namespace faultlab::server::lab::rehearsal {

core::Status RigBody::Accept(std::uint64_t epoch) {
  if (epoch < epoch_) {
    return core::Error{core::ErrorCode::kStale,
                       "the rig has seen a newer lease",
                       std::string(hardware::kLeaseField)};
  }
  if (epoch > epoch_) running_ = false;
  epoch_ = epoch;
  accepted_(id_, epoch);
  return core::Done{};
}

void RigBody::Fence(std::uint64_t epoch) {
  if (epoch <= epoch_) return;
  epoch_ = epoch;
  running_ = false;
}

RehearsedRig::RehearsedRig(hardware::RigDescription description, std::shared_ptr<RigBody> body)
    : description_(std::move(description)), body_(std::move(body)) {}

RehearsedRig::RehearsedRig(hardware::RigDescription description,
                           std::shared_ptr<RigBody> body,
                           std::shared_ptr<std::deque<InFlight>> line,
                           const Sender& sender,
                           Way way)
    : description_(std::move(description)),
      body_(std::move(body)),
      line_(std::move(line)),
      sender_(&sender),
      way_(std::move(way)) {}

core::Status RehearsedRig::Arm(hardware::RunPlan, hardware::Epoch epoch) {
  armed_ = static_cast<std::uint64_t>(epoch);
  return body_->Accept(armed_);
}

core::Status RehearsedRig::Start(hardware::Epoch epoch) {
  const core::Status accepted = body_->Accept(static_cast<std::uint64_t>(epoch));
  if (accepted.ok()) body_->Run(true);
  return accepted;
}

core::Status RehearsedRig::Command(hardware::Epoch epoch, const hardware::RigCommand&) {
  const auto number = static_cast<std::uint64_t>(epoch);
  if (line_ == nullptr) return body_->Accept(number);
  if (number < fenced_) {
    return core::Error{core::ErrorCode::kStale, "a newer lease exists", "epoch"};
  }
  if (const auto arrives = way_()) line_->push_back({*arrives, number, false, *sender_});
  return core::Done{};
}

void RehearsedRig::Fence(hardware::Epoch epoch) {
  const auto number = static_cast<std::uint64_t>(epoch);
  if (line_ == nullptr) return body_->Fence(number);
  fenced_ = std::max(fenced_, number);  // nothing older leaves the server
  if (const auto arrives = way_()) line_->push_back({*arrives, number, true, *sender_});
}

}  // namespace faultlab::server::lab::rehearsal
