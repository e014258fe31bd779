#pragma once

#include <stdexcept>
#include <string>

namespace faultlab::hardware {

/// A device that does not do what it was asked. Ends the run in a safe stop.
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A driver call that does not return: nobody knows what the board does now.
class DriverHang : public IoError {
 public:
  DriverHang(const std::string& what, double waited_s, double limit_s)
      : IoError(what), waited_s_(waited_s), limit_s_(limit_s) {}
  double waited_s() const { return waited_s_; }
  double limit_s() const { return limit_s_; }

 private:
  double waited_s_;
  double limit_s_;
};

}  // namespace faultlab::hardware
