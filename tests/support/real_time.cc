#include "tests/support/real_time.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace faultlab::tests {
namespace {

using Steady = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kAwayMax{20};
constexpr int kTriesMax = 5;
constexpr const char* kTry = "FAULTLAB_REAL_TIME_TRY";

/// For how long each core did nothing for us, at most.
class CoreWatch {
 public:
  CoreWatch() {
    cpu_set_t ours;
    CPU_ZERO(&ours);
    sched_getaffinity(0, sizeof ours, &ours);
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (CPU_ISSET(core, &ours)) threads_.emplace_back([this, core] { Watch(core); });
    }
  }
  ~CoreWatch() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

  milliseconds away() const { return std::chrono::duration_cast<milliseconds>(away_.load()); }

 private:
  void Watch(int core) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    pthread_setaffinity_np(pthread_self(), sizeof one, &one);
    while (!stop_) {
      const Steady::time_point due = Steady::now() + milliseconds(5);
      std::this_thread::sleep_until(due);
      const Steady::duration late = Steady::now() - due;
      Steady::duration longest = away_;
      while (late > longest && !away_.compare_exchange_weak(longest, late)) {
      }
    }
  }

  std::atomic<Steady::duration> away_{Steady::duration(0)};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

class FailedTests final : public testing::EmptyTestEventListener {
 public:
  void OnTestEnd(const testing::TestInfo& test) override {
    if (!test.result()->Failed()) return;
    if (!names_.empty()) names_ += ':';
    names_ += std::string(test.test_suite_name()) + "." + test.name();
  }
  const std::string& names() const { return names_; }

 private:
  std::string names_;
};

}  // namespace

int RunInRealTime(int argc, char** argv, const std::function<void()>& at_end) {
  testing::InitGoogleTest(&argc, argv);
  const auto failed = new FailedTests;  // GoogleTest's to delete
  testing::UnitTest::GetInstance()->listeners().Append(failed);
  milliseconds away{0};
  int status = 0;
  {
    const CoreWatch watch;
    status = RUN_ALL_TESTS();
    away = watch.away();
  }
  if (at_end) at_end();
  const char* const before = std::getenv(kTry);
  const int tries = before == nullptr ? 1 : std::atoi(before);
  if (status == 0 || failed->names().empty() || away <= kAwayMax || tries >= kTriesMax) {
    return status;
  }
  std::printf("A core was away for %ld ms: try %d of %d of what failed.\n",
              static_cast<long>(away.count()),
              tries + 1,
              kTriesMax);
  std::fflush(stdout);
  setenv(kTry, std::to_string(tries + 1).c_str(), /*overwrite=*/1);
  std::string filter = "--gtest_filter=" + failed->names();
  char* const words[] = {argv[0], filter.data(), nullptr};
  execv("/proc/self/exe", words);
  std::perror("execv");
  return status;
}

}  // namespace faultlab::tests
