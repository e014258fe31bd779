#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace faultlab::hardware {

inline constexpr int kAgentPort = 7667;

inline std::string Url(int port) {
  return "udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0";
}

inline int StatusOf(pid_t pid) {
  int status = 0;
  waitpid(pid, &status, 0);
  return status;
}

/// lcm-logger as a process; ends with this object. It leaves out its own LCM_SELF_TEST, which
/// liblcm sends again on a machine that stands still, and then delivers as anybody's message.
class Logger {
 public:
  explicit Logger(const std::string& file) {
    std::filesystem::remove(file);
    pid_ = fork();
    if (pid_ == 0) {
      const std::string url = "--lcm-url=" + Url(kAgentPort);
      execlp("lcm-logger",
             "lcm-logger",
             "-q",
             "-f",
             "-v",
             "-c",
             "LCM_SELF_TEST",
             url.c_str(),
             file.c_str(),
             static_cast<char*>(nullptr));
      _exit(127);
    }
  }
  ~Logger() {
    if (!runs()) return;
    kill(pid_, SIGINT);
    (void)StatusOf(pid_);
  }
  bool runs() {
    if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) != 0) pid_ = 0;
    return pid_ > 0;
  }

 private:
  pid_t pid_ = 0;
};

}  // namespace faultlab::hardware
