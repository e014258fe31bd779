#pragma once

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <utility>

namespace faultlab::tests {

/// A descriptor that is closed with this object.
class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

/// A listener on loopback. The kernel accepts its connections, but only the test answers them.
class LoopbackListener {
 public:
  LoopbackListener() : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    EXPECT_EQ(bind(socket_.fd(), reinterpret_cast<sockaddr*>(&here), size), 0);
    EXPECT_EQ(listen(socket_.fd(), 128), 0);
    EXPECT_EQ(getsockname(socket_.fd(), reinterpret_cast<sockaddr*>(&here), &size), 0);
    port_ = ntohs(here.sin_port);
  }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  /// Whether a client has connected that is not yet accepted.
  bool HasBeenAsked() const {
    pollfd here{.fd = socket_.fd(), .events = POLLIN, .revents = 0};
    return poll(&here, 1, 0) == 1;
  }
  /// Waits for a client. A closed descriptor (-1) after Shutdown.
  Socket Accept() { return Socket(accept(socket_.fd(), nullptr, nullptr)); }

  void Shutdown() { shutdown(socket_.fd(), SHUT_RDWR); }

 private:
  Socket socket_;
  int port_ = 0;
};

}  // namespace faultlab::tests
