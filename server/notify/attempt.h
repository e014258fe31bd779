#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace faultlab::server::notify {

/// What became of one attempt to send a message.
struct Attempt {
  enum class Outcome : std::uint8_t {
    kTaken,
    kNotNow,   ///< the receiver is away or overloaded: nothing else is sent to it for a while
    kRefused,  ///< this message; others may be taken. It is tried again
    kNever,    ///< this message, for good
  };
  Outcome outcome = Outcome::kTaken;
  std::string error{};                 ///< for admins; empty when taken
  std::chrono::milliseconds pause{0};  ///< in which the receiver wants nothing else
};

}  // namespace faultlab::server::notify
