#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/types/result.h"
#include "server/auth/throttle.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// Slows down the guessing of passwords without giving a stranger the means to lock the owner out.
///
///   a device that has signed in to the account before    5 tries of its own, then as everybody:
///   account and network together                         5 tries
///   the network, whatever the account                   20 tries
///   the account, from wherever                          30 tries
///
/// Of one process: several servers on one database each count for themselves. Thread-safe.
class SignInLimits {
 public:
  /// A try that has begun: it stays a failure unless it is given back.
  class Pass {
   public:
    /// The password was right.
    void Succeeded();
    /// Nobody looked at the password: the database or the hasher had no time.
    void NotJudged();

   private:
    friend class SignInLimits;
    struct Counted {
      Throttle* throttle;
      std::string name;
      bool shared;  ///< with tries of others, which a success does not forgive
    };
    core::Status Count(Throttle& throttle, const std::string& name, bool shared, WallTime now);
    std::vector<Counted> counted_;
  };

  /// `account` is the login, whether there is such an account or not; `device` is empty unless the
  /// device is known to have signed in to it. kTooMany with the seconds to wait.
  core::Result<Pass> Begin(const std::string& account,
                           const std::string& address,
                           const std::string& device,
                           WallTime now);

 private:
  Throttle by_device_{5};
  Throttle by_pair_{5};
  Throttle by_network_{20};
  Throttle by_account_{30};
};

}  // namespace faultlab::server
