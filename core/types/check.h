#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace faultlab::core {

/// A programming error: a caller broke a contract. Caught only at the top of the rig loop and of a
/// connection, which make the rig safe, end the run and log.
class ContractError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace internal {
template <typename... Values>
[[noreturn]] void FailContract(const char* condition,
                               const char* file,
                               int line,
                               const Values&... values) {
  std::ostringstream text;
  text << file << ":" << line << ": contract broken: " << condition;
  ((text << ' ' << values), ...);
  throw ContractError(text.str());
}
}  // namespace internal
}  // namespace faultlab::core

/// LAB_CHECK(condition, values..) throws ContractError with the values when the condition is false.
#define LAB_CHECK(condition, ...)                                     \
  do {                                                                \
    if (!(condition)) {                                               \
      ::faultlab::core::internal::FailContract(                       \
          #condition, __FILE__, __LINE__ __VA_OPT__(, ) __VA_ARGS__); \
    }                                                                 \
  } while (false)
