#pragma once

#include <chrono>
#include <thread>

namespace faultlab::tests {

/// Asks again and again until `happened()` is true. @returns false after two minutes: a guard
/// against hanging, not an expectation.
template <typename Happened>
[[nodiscard]] bool Await(const Happened& happened) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (!happened()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace faultlab::tests
