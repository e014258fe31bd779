#pragma once

#include <string>
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
/// The limit of the account stops tries from everywhere but a network from which its owner has
/// signed in before: who owns ten thousand networks has no more tries than who owns ten.
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

  struct Attempt {
    std::string account;  ///< the login, also if no such account exists
    std::string address;
    std::string device{};           ///< empty unless it is known to have signed in to the account
    bool network_is_known = false;  ///< that of the address, from an earlier sign-in to the account
  };
  /// kTooMany with the seconds to wait.
  core::Result<Pass> Begin(const Attempt& attempt, WallTime now);

 private:
  Throttle by_device_{5};
  Throttle by_pair_{5};
  Throttle by_network_{20};
  Throttle by_account_{30};
};

}  // namespace faultlab::server
