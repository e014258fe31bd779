#pragma once

#include <cstdint>

namespace faultlab::testing {

/// Counts the calls of operator new that this thread makes while the guard lives. Link
/// tests/support/heap_guard.cc, which replaces the global operators.
///   HeapGuard guard;  HotPath();  EXPECT_EQ(guard.allocations(), 0);
class HeapGuard {
 public:
  HeapGuard();
  std::int64_t allocations() const;

 private:
  std::int64_t before_;
};

}  // namespace faultlab::testing
