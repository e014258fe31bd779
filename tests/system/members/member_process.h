#pragma once

#include <sys/types.h>

#include <string>

namespace faultlab::tests {

/// A `faultlab serve` in a process of its own, on a free port of 127.0.0.1. It dies with this
/// process.
class MemberProcess {
 public:
  /// Throws std::runtime_error unless the server listens. Its log is in `folder`/`id`.log.
  /// @param settings  more lines for its configuration file
  MemberProcess(const std::string& folder,
                const std::string& id,
                const std::string& database_url,
                const std::string& settings);
  ~MemberProcess();  ///< SIGTERM, and waits
  MemberProcess(const MemberProcess&) = delete;
  MemberProcess& operator=(const MemberProcess&) = delete;

  int port() const { return port_; }
  /// Sends SIGSTOP; the server does nothing until Wake.
  void Freeze();
  void Wake();
  /// Sends SIGKILL; the server sends nothing more.
  void Kill();

 private:
  void End(int signal);

  pid_t process_ = -1;
  int port_ = 0;
};

}  // namespace faultlab::tests
