#include "tests/support/real_time.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

namespace faultlab::tests {
namespace {

using Steady = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kAwayMax{20};
constexpr int kTriesMax = 5;
constexpr const char* kTry = "FAULTLAB_REAL_TIME_TRY";

/// Stores in `away_ms` the longest time for which this core did not run this process.
void Watch(int core, std::atomic<int>& away_ms) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(core, &one);
  pthread_setaffinity_np(pthread_self(), sizeof one, &one);
  while (true) {
    const Steady::time_point due = Steady::now() + milliseconds(5);
    std::this_thread::sleep_until(due);
    const auto late = std::chrono::duration_cast<milliseconds>(Steady::now() - due);
    int longest = away_ms;
    while (late.count() > longest &&
           !away_ms.compare_exchange_weak(longest, static_cast<int>(late.count()))) {
    }
  }
}

/// Watches every core from a separate process, because some tests fork and must have no other
/// threads.
class CoreWatch {
 public:
  CoreWatch() {
    void* const shared = mmap(nullptr,
                              sizeof(std::atomic<int>),
                              PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS,
                              -1,
                              0);
    if (shared == MAP_FAILED) throw std::runtime_error("no memory to share");
    away_ms_ = new (shared) std::atomic<int>(0);
    watcher_ = fork();
    if (watcher_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    cpu_set_t ours;
    CPU_ZERO(&ours);
    sched_getaffinity(0, sizeof ours, &ours);
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (CPU_ISSET(core, &ours)) std::thread([=, this] { Watch(core, *away_ms_); }).detach();
    }
    while (true) pause();
  }
  ~CoreWatch() {
    if (watcher_ <= 0) return;
    kill(watcher_, SIGKILL);
    waitpid(watcher_, nullptr, 0);
  }
  CoreWatch(const CoreWatch&) = delete;
  CoreWatch& operator=(const CoreWatch&) = delete;

  milliseconds away() const { return milliseconds(*away_ms_); }

 private:
  std::atomic<int>* away_ms_ = nullptr;
  pid_t watcher_ = -1;
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
