#include "server/upkeep/asked_checks.h"

#include <string>

namespace faultlab::server {

bool AskedChecks::Add(const lab::Lease& lease) {
  if (!known_.emplace(lease.rig, lease.epoch).second) return false;
  waiting_.push_back(lease);
  return true;
}

lab::Lease AskedChecks::Begin() {
  lab::Lease lease = std::move(waiting_.front());
  waiting_.pop_front();
  return lease;
}

lab::RigVerdict NotBegun(const core::Error& error) {
  lab::RigVerdict verdict = lab::VerdictOf(error);
  verdict.put_off = verdict.put_off || error.code == core::ErrorCode::kNotFound ||
                    error.code == core::ErrorCode::kUnavailable;
  return verdict;
}

bool TellVerdict(lab::LabService& lab,
                 const lab::Lease& lease,
                 const lab::RigVerdict& verdict,
                 const std::function<void(std::string_view)>& log) {
  const auto put_off = [&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.CheckPutOff(lease.rig, lease.epoch, verdict.text, now);
  };
  const core::Status told =
      verdict.put_off ? lab.Do(put_off)
                      : lab.CleaningDone(lease.rig, lease.epoch, verdict.passed, verdict.text);
  if (told.ok() || told.error().code == core::ErrorCode::kStale) return false;
  log("rig " + lease.rig + ": its check is not stored yet: " + told.error().message);
  return told.error().code == core::ErrorCode::kBusy ||
         told.error().code == core::ErrorCode::kUnavailable;
}

}  // namespace faultlab::server
