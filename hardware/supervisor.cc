#include "hardware/supervisor.h"
#include "core/types/number_text.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <optional>
#include <span>

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

/// Waits for the end of a process.
bool EndsWithin(int process, std::chrono::milliseconds patience) {
  pollfd wait{.fd = process, .events = POLLIN, .revents = 0};
  int ready = 0;
  while ((ready = poll(&wait, 1, static_cast<int>(patience.count()))) < 0 && errno == EINTR) {
  }
  return ready > 0;
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
  const int process = OpenProcess(pid);
  const bool ended = EndsWithin(process, patience);
  close(process);
  int status = 0;
  if (ended) {
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
      : child_(child), ended_(OpenProcess(child)), make_safe_(make_safe), options_(options) {}
  ~SecondLine() { close(ended_); }
  SecondLine(const SecondLine&) = delete;
  SecondLine& operator=(const SecondLine&) = delete;

  /// @returns the child's wait status.
  int Watch(int words) {
    while (true) {
      pollfd waits[2] = {{.fd = ended_, .events = POLLIN, .revents = 0},
                         {.fd = words, .events = POLLIN, .revents = 0}};
      const int ready = poll(waits, 2, UntilDeadlineMs());
      if (ready < 0) continue;  // a signal, passed on
      if (waits[0].revents != 0) break;
      if (waits[1].revents != 0) {
        if (Hear(words)) continue;
        if (ended_ < 0) break;  // no pidfd (Linux before 5.3): the closed pipe tells
        words = -1;             // poll leaves it out; the child's end is near
      } else if (deadline_ && Steady::now() >= *deadline_) {
        OnSilence();
      }
    }
    int status = 0;
    while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
  }

  /// After the child's death by a signal.
  void CleanUp() {
    bool safe = false;
    for (int attempt = 0; attempt < kSafeTries && !safe; ++attempt) safe = MakeSafe();
    if (why_killed_ != nullptr) Say(why_killed_);
    if (!safe) {
      Say("the agent was killed and the bench is NOT safe: emergency stop");
    } else if (heard_at_ == Steady::time_point()) {
      Say("the agent was killed: drive 0, relays nominal");
    } else {
      const std::chrono::duration<double, std::milli> silence = Steady::now() - heard_at_;
      const std::string text =
          core::Format("the agent was killed: drive 0, relays nominal, %.0f ms after its last word",
                       silence.count());
      Say(text.c_str());
    }
  }

 private:
  using Steady = std::chrono::steady_clock;  // stands while the machine is suspended

  bool MakeSafe() { return MakeSafeInTime(make_safe_, options_.patience); }
  void Say(const char* text) const {
    if (options_.say) options_.say(text);
  }

  int UntilDeadlineMs() const {
    if (!deadline_) return -1;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(*deadline_ - Steady::now());
    return static_cast<int>(std::max<std::int64_t>(left.count(), 0));
  }

  /// Takes what the child has said. @returns false at the end of the pipe.
  bool Hear(int words) {
    Word said[256];
    const ssize_t size = read(words, said, sizeof said);
    if (size <= 0) return size < 0 && (errno == EAGAIN || errno == EINTR);
    for (const Word word : std::span(said).first(static_cast<std::size_t>(size))) {
      if (word == kCallForHelp) {
        Help();
        continue;
      }
      heard_at_ = Steady::now();
      extended_ = false;
      if (word == kMotorOff) {
        deadline_.reset();
      } else {
        deadline_ = heard_at_ + SilenceAllowed(word, options_.silence_max);
      }
    }
    return true;
  }

  void OnSilence() {
    const Steady::time_point now = Steady::now();
    // Once: whoever is late each time must still act.
    if (now - *deadline_ > kLateMax && !extended_) {
      extended_ = true;
      deadline_ = now + options_.silence_max;
      return;
    }
    Kill("the agent drives and has fallen silent: it is killed");
  }

  // The bench comes before the log, which may have nobody who reads it.
  void Help() {
    deadline_.reset();
    const bool safe = MakeSafe();
    if (!safe) Kill("the bench does not answer the second line either: the agent is killed");
    Say("the agent calls for help: its driver hangs");
    if (safe) Say("the second line made the bench safe");
  }

  void Kill(const char* why) {
    deadline_.reset();
    why_killed_ = why;
    kill(child_, SIGKILL);
    if (EndsWithin(ended_, kDeathMax)) return;  // CleanUp follows
    Say(MakeSafe() ? "the agent hangs in the kernel; the second line made the bench safe"
                   : "the agent hangs in the kernel and the bench is NOT safe: emergency stop");
  }

  static constexpr int kSafeTries = 3;
  /// A supervisor later than this was not looking.
  static constexpr std::chrono::milliseconds kLateMax{100};
  static constexpr std::chrono::milliseconds kDeathMax{200};

  const pid_t child_;
  const int ended_;
  const std::function<bool()>& make_safe_;
  const SupervisorOptions& options_;
  std::optional<Steady::time_point> deadline_;  ///< of the child's next word, while it drives
  Steady::time_point heard_at_;                 ///< a word of the heartbeat, last
  bool extended_ = false;                       ///< the deadline, since the last word
  const char* why_killed_ = nullptr;            ///< by us
};

/// A pipe whose ends never make anybody wait.
bool OpenPipe(int (&ends)[2]) {
  return pipe2(ends, O_CLOEXEC | O_NONBLOCK) == 0;
}

}  // namespace

int Supervise(const std::function<int(const SendWord& send)>& work,
              const std::function<bool()>& make_safe,
              const SupervisorOptions& options) {
  const pid_t supervisor = getpid();
  int pipe_ends[2] = {-1, -1};
  std::fflush(nullptr);
  const pid_t pid = OpenPipe(pipe_ends) ? fork() : -1;
  // No second line is better than no rig.
  if (pid < 0) return work([](Word) {});
  if (pid == 0) {
    close(pipe_ends[0]);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != supervisor) _exit(1);  // it died between fork and here
    // A word to a supervisor that has died must not kill before SIGTERM's safe stop.
    (void)std::signal(SIGPIPE, SIG_IGN);
    const int status = work([fd = pipe_ends[1]](Word word) { (void)!write(fd, &word, 1); });
    std::fflush(nullptr);
    _exit(status);
  }
  close(pipe_ends[1]);
  if (options.fifo_priority > 0) {
    const sched_param parameters{.sched_priority = options.fifo_priority};
    (void)sched_setscheduler(0, SCHED_FIFO, &parameters);
  }
  SecondLine line(pid, make_safe, options);
  int status = 0;
  {
    const SignalsToChild signals(pid);
    status = line.Watch(pipe_ends[0]);
  }
  close(pipe_ends[0]);
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  line.CleanUp();
  return 1;
}

}  // namespace faultlab::hardware
