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

core::Result<SignInLimits::Pass> SignInLimits::Begin(const std::string& account,
                                                     const std::string& address,
                                                     const std::string& device,
                                                     WallTime now) {
  Pass pass;
  if (!device.empty() && pass.Count(by_device_, account + " " + device, false, now).ok()) {
    return pass;
  }
  const std::string network = AddressKey(address);
  const std::string pair = account + " " + network;
  // An account and network without failures here is not blocked by failures elsewhere.
  const bool first = !by_pair_.Knows(pair);
  core::Status status = pass.Count(by_pair_, pair, false, now);
  if (status.ok()) status = pass.Count(by_network_, network, true, now);
  if (status.ok() || first) {
    const core::Status account_wide = pass.Count(by_account_, account, true, now);
    if (status.ok()) status = account_wide;
  }
  if (status.ok() || first) return pass;
  pass.NotJudged();
  return status.error();
}

}  // namespace faultlab::server
