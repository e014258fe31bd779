#pragma once

#include <stdexcept>

namespace faultlab::hardware {

/// A device that does not do what it was asked. Ends the run in a safe stop.
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace faultlab::hardware
