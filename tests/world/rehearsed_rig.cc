#include "tests/world/rehearsed_rig.h"

#include <algorithm>
#include <utility>

namespace faultlab::server::lab::rehearsal {
namespace {

core::Error Silent(const std::string& rig) {
  return core::Refuse("rig_silent", "/rig", {{"rig", rig}});
}

}  // namespace

core::Status RigBody::Accept(std::uint64_t epoch) {
  if (!fence_.Admits(epoch)) {
    return core::Error{core::ErrorCode::kStale,
                       "the rig has seen a newer lease",
                       std::string(hardware::kLeaseField)};
  }
  Fence(epoch);
  accepted_(id_, epoch);
  return core::Done{};
}

void RigBody::Fence(std::uint64_t epoch) {
  if (epoch > fence_.epoch()) running_ = false;
  fence_.Raise(epoch);
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
  if (!body_->answers()) return Silent(description_.id);
  armed_ = static_cast<std::uint64_t>(epoch);
  return body_->Accept(armed_);
}

core::Status RehearsedRig::Start(hardware::Epoch epoch) {
  if (!body_->answers()) return Silent(description_.id);
  const core::Status accepted = body_->Accept(static_cast<std::uint64_t>(epoch));
  if (accepted.ok()) body_->Run(true);
  return accepted;
}

core::Status RehearsedRig::Command(hardware::Epoch epoch, const hardware::RigCommand&) {
  const auto number = static_cast<std::uint64_t>(epoch);
  if (line_ == nullptr) return body_->answers() ? body_->Accept(number) : Silent(description_.id);
  if (!fence_.Admits(number)) {
    return core::Error{core::ErrorCode::kStale, "a newer lease exists", "epoch"};
  }
  if (const auto arrives = way_()) line_->push_back({*arrives, number, false, *sender_});
  return core::Done{};
}

void RehearsedRig::Fence(hardware::Epoch epoch) {
  const auto number = static_cast<std::uint64_t>(epoch);
  if (line_ == nullptr) return body_->Fence(number);
  fence_.Raise(number);  // nothing older leaves the server
  if (const auto arrives = way_()) line_->push_back({*arrives, number, true, *sender_});
}

}  // namespace faultlab::server::lab::rehearsal
