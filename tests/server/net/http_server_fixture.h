#pragma once

#include <gtest/gtest.h>

#include <unistd.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/net/http_server.h"

namespace faultlab::server {

/// Blocks a handler until it is opened.
class Gate {
 public:
  void Pass() {
    std::unique_lock lock(mutex_);
    ++inside_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
  }
  void WaitForInside(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this, count] { return inside_ >= count; });
  }
  void Open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int inside_ = 0;
  bool open_ = false;
};

class HttpServerTest : public ::testing::Test {
 protected:
  HttpServerTest() {
    options_.listen = "127.0.0.1:0";
    options_.on_error = [this](std::string_view text) {
      const std::lock_guard lock(mutex_);
      errors_.emplace_back(text);
    };
    Add(HttpMethod::kGet, "/hello", RunsOn::kInline, 0, [](const HttpRequest&) {
      HttpResponse response;
      response.body = R"({"hello":"world"})";
      return response;
    });
    Add(HttpMethod::kPost, "/echo", RunsOn::kPool, 1000, [](const HttpRequest& request) {
      HttpResponse response;
      response.body = std::string(request.body);
      return response;
    });
    Add(HttpMethod::kGet, "/wait", RunsOn::kPool, 0, [this](const HttpRequest&) {
      gate_.Pass();
      return HttpResponse{};
    });
    Add(HttpMethod::kGet, "/throw", RunsOn::kPool, 0, [](const HttpRequest&) -> HttpResponse {
      throw std::runtime_error("secret detail");
    });
    Add(HttpMethod::kGet, "/peer", RunsOn::kInline, 0, [](const HttpRequest& request) {
      HttpResponse response;
      response.body = std::string(request.remote_address) + (request.https ? " https" : " http");
      return response;
    });
  }

  void Add(HttpMethod method,
           const std::string& pattern,
           RunsOn runs_on,
           std::size_t body_bytes_max,
           std::function<HttpResponse(const HttpRequest&)> handle) {
    router_.Add({method, pattern, runs_on, body_bytes_max, std::move(handle)});
  }

  int Start() {
    server_ = std::make_unique<HttpServer>(
        options_, router_, [this](const HttpRequest& request) -> UpgradeDecision {
          if (request.path != "/ws") return Problem(404, "not_found", "Not found", "no");
          return [this](UpgradedSocket socket) {
            const std::lock_guard lock(mutex_);
            pending_ = socket.pending;
            EXPECT_EQ(write(socket.fd, "taken", 5), 5);
            close(socket.fd);
          };
        });
    const core::Status started = server_->Start();
    EXPECT_TRUE(started.ok());
    return server_->port();
  }

  HttpServerOptions options_;
  Router router_;
  Gate gate_;
  std::mutex mutex_;
  std::vector<std::string> errors_;
  std::string pending_;
  std::unique_ptr<HttpServer> server_;
};

}  // namespace faultlab::server
