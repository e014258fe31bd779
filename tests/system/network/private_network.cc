// main of the tests that need a network: a network namespace for this process alone.
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "tests/system/network/network_world.h"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  constexpr int kSkip = 77;
  if (geteuid() != 0 || unshare(CLONE_NEWNET) != 0) {
    std::puts("skipped: a private network namespace needs root (CAP_SYS_ADMIN)");
    return kSkip;
  }
  if (std::system("ip link set lo up && ip link set lo multicast on && "
                  "ip route add 239.255.76.67/32 dev lo") != 0) {
    std::puts("skipped: this namespace takes no multicast route (is iproute2 installed?)");
    return kSkip;
  }
  (void)faultlab::hardware::KeyFolder();  // named before the first fork
  const int status = RUN_ALL_TESTS();
  std::error_code ignored;
  std::filesystem::remove_all(faultlab::hardware::KeyFolder(), ignored);
  return status;
}
