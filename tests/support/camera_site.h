#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "tests/support/loopback_listener.h"

namespace faultlab::tests {

/// A small HTTP server on loopback in place of a camera: one request per connection, one at a time.
/// By default every picture is a JPEG that ends in its number: 1, 2, ..
class CameraSite {
 public:
  CameraSite() : thread_([this] { Serve(); }) {}
  ~CameraSite() {
    Open();
    listener_.Shutdown();
    thread_.join();
  }
  CameraSite(const CameraSite&) = delete;
  CameraSite& operator=(const CameraSite&) = delete;

  static std::string Picture(int number) {
    return "\xFF\xD8\xFF picture " + std::to_string(number);
  }
  std::string url() const { return "http://" + listener_.address() + "/snapshot"; }
  int asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }
  /// What it sends from now on; an empty text: pictures.
  void Answers(const std::string& body, int status = 200) {
    const std::lock_guard lock(mutex_);
    body_ = body;
    status_ = status;
  }
  /// From now on no request is answered before Open().
  void Close() { SetOpen(false); }
  void Open() { SetOpen(true); }
  void WaitForAsked(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return asked_ >= count; });
  }

 private:
  void SetOpen(bool open) {
    {
      const std::lock_guard lock(mutex_);
      open_ = open;
    }
    changed_.notify_all();
  }
  void Serve() {
    for (;;) {
      const Socket client = listener_.Accept();
      if (client.fd() < 0) return;
      std::string request(8192, '\0');
      if (recv(client.fd(), request.data(), request.size(), 0) <= 0) continue;
      const std::string answer = NextAnswer();
      // A client that found the answer too large or too late has gone.
      (void)send(client.fd(), answer.data(), answer.size(), MSG_NOSIGNAL);
    }
  }
  std::string NextAnswer() {
    std::unique_lock lock(mutex_);
    ++asked_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
    const std::string body = body_.empty() ? Picture(asked_) : body_;
    return "HTTP/1.1 " + std::to_string(status_) +
           " Said\r\nConnection: close\r\nContent-Length: " + std::to_string(body.size()) +
           "\r\n\r\n" + body;
  }

  LoopbackListener listener_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int asked_ = 0;
  int status_ = 200;
  bool open_ = true;
  std::string body_;
  std::thread thread_;
};

}  // namespace faultlab::tests
