#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/types/result.h"
#include "server/auth/throttle.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// Slows down the guessing of passwords without letting others lock the owner out. Limits of
///
///   a device that has signed in to the account before    5 tries, then the limits below
///   account and network together                         5 tries
///   the network, for all accounts                       20 tries
///   the account, from all networks                      30 tries
///
/// In one process: several servers on one database count separately. Thread-safe.
class SignInLimits {
 public:
  /// A try that has begun: it counts as a failure unless one of the functions below is called.
  class Pass {
   public:
    /// The password was right.
    void Succeeded();
    /// The password was not checked, because the database or the hasher was busy.
    void NotJudged();

   private:
    friend class SignInLimits;
    struct Counted {
      Throttle* throttle;
      std::string name;
      bool shared;  ///< counted together with tries of others; a success does not clear it
    };
    core::Status Count(Throttle& throttle, const std::string& name, bool shared, WallTime now);
    std::vector<Counted> counted_;
  };

  /// `account` is the login, also if no such account exists; `device` is empty unless the device is
  /// known to have signed in to it. kTooMany with the seconds to wait.
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
