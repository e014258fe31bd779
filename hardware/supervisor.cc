#include "hardware/supervisor.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
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

/// SIGTERM and SIGINT go to the child while this lives.
class SignalsToChild {
 public:
  explicit SignalsToChild(pid_t child) {
    child_pid = child;
    struct sigaction pass_on = {};
    pass_on.sa_handler = PassOn;
    sigaction(SIGTERM, &pass_on, &term_before_);
    sigaction(SIGINT, &pass_on, &int_before_);
  }
  ~SignalsToChild() {
    child_pid = 0;
    sigaction(SIGTERM, &term_before_, nullptr);
    sigaction(SIGINT, &int_before_, nullptr);
  }
  SignalsToChild(const SignalsToChild&) = delete;
  SignalsToChild& operator=(const SignalsToChild&) = delete;

 private:
  struct sigaction term_before_ = {};
  struct sigaction int_before_ = {};
};

/// A descriptor that becomes readable when the process has ended.
int OpenProcess(pid_t pid) {
  return static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
}

/// make_safe in a process of its own: a driver that hangs there is killed with it.
bool MakeSafeInTime(const std::function<bool()>& make_safe, std::chrono::milliseconds patience) {
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid < 0) return make_safe();
  if (pid == 0) {
    const bool safe = make_safe();
    std::fflush(nullptr);
    _exit(safe ? 0 : 1);
  }
  const int ended = OpenProcess(pid);
  pollfd wait{.fd = ended, .events = POLLIN, .revents = 0};
  int ready = 0;
  while ((ready = poll(&wait, 1, static_cast<int>(patience.count()))) < 0 && errno == EINTR) {
  }
  close(ended);
  int status = 0;
  if (ready > 0) {
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }
  kill(pid, SIGKILL);
  waitpid(pid, &status, WNOHANG);  // one that the kernel holds in the driver is not waited for
  return false;
}

class SecondLine {
 public:
  SecondLine(pid_t child, const std::function<bool()>& make_safe, const SupervisorOptions& options)
      : child_(child), make_safe_(make_safe), options_(options) {}

  /// @returns the child's wait status.
  int Watch(int help) {
    const int ended = OpenProcess(child_);
    while (true) {
      pollfd waits[2] = {{.fd = ended, .events = POLLIN, .revents = 0},
                         {.fd = help, .events = POLLIN, .revents = 0}};
      if (poll(waits, 2, -1) < 0) continue;  // a signal, passed on
      if (waits[0].revents != 0) break;
      char word = 0;
      if (waits[1].revents != 0) {
        if (read(help, &word, 1) == 1) {
          Help();
        } else if (ended < 0) {
          break;  // no pidfd (Linux before 5.3): the closed pipe tells
        } else {
          help = -1;  // poll leaves it out; the child's end is near
        }
      }
    }
    close(ended);
    int status = 0;
    while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
  }

  bool MakeSafe() { return MakeSafeInTime(make_safe_, options_.patience); }
  void Say(const char* text) const {
    if (options_.say) options_.say(text);
  }

 private:
  void Help() {
    Say("the agent calls for help: its driver hangs");
    if (MakeSafe()) {
      Say("the second line made the bench safe");
      return;
    }
    Say("the bench does not answer the second line either: the agent is killed");
    kill(child_, SIGKILL);
  }

  const pid_t child_;
  const std::function<bool()>& make_safe_;
  const SupervisorOptions& options_;
};

}  // namespace

int Supervise(const std::function<int(const std::function<void()>& call_for_help)>& work,
              const std::function<bool()>& make_safe,
              const SupervisorOptions& options) {
  const pid_t supervisor = getpid();
  int pipe_ends[2] = {-1, -1};
  std::fflush(nullptr);
  const bool piped = pipe2(pipe_ends, O_CLOEXEC) == 0;
  const pid_t pid = piped ? fork() : -1;
  // No second line is better than no rig.
  if (pid < 0) return work([] {});
  if (pid == 0) {
    close(pipe_ends[0]);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != supervisor) _exit(1);  // it died between fork and here
    const int status = work([fd = pipe_ends[1]] {
      const char word = '!';
      (void)!write(fd, &word, 1);
    });
    std::fflush(nullptr);
    _exit(status);
  }
  close(pipe_ends[1]);
  SecondLine line(pid, make_safe, options);
  int status = 0;
  {
    const SignalsToChild signals(pid);
    status = line.Watch(pipe_ends[0]);
  }
  close(pipe_ends[0]);
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  line.Say(line.MakeSafe() ? "the agent was killed: drive 0, relays nominal"
                           : "the agent was killed and the bench is NOT safe: emergency stop");
  return 1;
}

}  // namespace faultlab::hardware
