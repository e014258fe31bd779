#include "hardware/supervisor.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>

namespace faultlab::hardware {
namespace {

std::atomic<pid_t> child_pid{0};

void PassOn(int signal) {
  const pid_t pid = child_pid.load();
  if (pid > 0) kill(pid, signal);
}

}  // namespace

int Supervise(const std::function<int()>& work, const std::function<void()>& make_safe) {
  const pid_t supervisor = getpid();
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid < 0) return work();  // no second line is better than no rig; the caller's log says so
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != supervisor) _exit(1);  // it died between fork and here
    const int status = work();
    std::fflush(nullptr);
    _exit(status);
  }
  child_pid = pid;
  struct sigaction pass_on = {};
  pass_on.sa_handler = PassOn;
  struct sigaction term_before = {};
  struct sigaction int_before = {};
  sigaction(SIGTERM, &pass_on, &term_before);
  sigaction(SIGINT, &pass_on, &int_before);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  child_pid = 0;
  sigaction(SIGTERM, &term_before, nullptr);
  sigaction(SIGINT, &int_before, nullptr);
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  make_safe();
  return 1;
}

}  // namespace faultlab::hardware
