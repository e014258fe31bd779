#include "server/auth/sign_in_limits.h"
#include "server/address_key.h"

namespace faultlab::server {

core::Status SignInLimits::Pass::Count(Throttle& throttle,
                                       const std::string& name,
                                       bool shared,
                                       WallTime now) {
  const core::Status status = throttle.Try(name, now);
  if (status.ok()) counted_.push_back({&throttle, name, shared});
  return status;
}

void SignInLimits::Pass::Succeeded() {
  for (const Counted& counted : std::exchange(counted_, {})) {
    if (counted.shared) counted.throttle->Forgive(counted.name);
    if (!counted.shared) counted.throttle->Forget(counted.name);
  }
}

void SignInLimits::Pass::NotJudged() {
  for (const Counted& counted : std::exchange(counted_, {})) {
    counted.throttle->Forgive(counted.name);
  }
}

core::Result<SignInLimits::Pass> SignInLimits::Begin(const Attempt& attempt, WallTime now) {
  const std::string& account = attempt.account;
  Pass pass;
  if (!attempt.device.empty() &&
      pass.Count(by_device_, account + " " + attempt.device, false, now).ok()) {
    return pass;
  }
  const std::string network = AddressKey(attempt.address);
  const std::string pair = account + " " + network;
  // Who has not failed here yet is not shut out by what others in the network did.
  const bool first = !by_pair_.Knows(pair);
  core::Status status = pass.Count(by_pair_, pair, false, now);
  if (status.ok()) status = pass.Count(by_network_, network, true, now);
  if (first) status = core::Done{};
  if (status.ok() && !attempt.network_is_known) {
    status = pass.Count(by_account_, account, true, now);
  }
  if (status.ok()) return pass;
  pass.NotJudged();
  return status.error();
}

}  // namespace faultlab::server
