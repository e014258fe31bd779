#include "server/oidc/provider.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace faultlab::server::oidc {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Takes connections on loopback and closes them, with the answer that it has or without a word.
class Site {
 public:
  Site() : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(fd_, any, size), 0);
    EXPECT_EQ(listen(fd_, 8), 0);
    EXPECT_EQ(getsockname(fd_, any, &size), 0);
    url_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] { Serve(); });
  }
  ~Site() {
    shutdown(fd_, SHUT_RDWR);
    thread_.join();
    close(fd_);
  }
  Site(const Site&) = delete;
  Site& operator=(const Site&) = delete;

  const std::string& url() const { return url_; }
  int asked() const { return asked_; }
  void Answers(bool yes) { answers_ = yes; }

 private:
  void Serve() {
    for (int client = 0; (client = accept(fd_, nullptr, nullptr)) >= 0; close(client)) {
      ++asked_;
      std::string request(8192, '\0');
      if (recv(client, request.data(), request.size(), 0) <= 0 || !answers_) continue;
      const std::string answer =
          "HTTP/1.1 200 OK\r\nContent-Length: 18\r\n\r\n{\"id_token\":\"abc\"}";
      EXPECT_GT(send(client, answer.data(), answer.size(), MSG_NOSIGNAL), 0);
    }
  }

  int fd_;
  std::string url_;
  std::atomic<int> asked_{0};
  std::atomic<bool> answers_{false};
  std::thread thread_;
};

TEST(Provider, WhoGaveNoAnswerIsNotWaitedForAgainForSomeSeconds) {
  Site site;
  ManualClock clock;
  ProviderSettings settings;
  settings.insecure_loopback = true;
  Provider provider(settings, clock);
  Discovery discovery;
  discovery.token_endpoint = site.url() + "/token";
  const auto ask = [&] { return provider.Exchange(discovery, "code", "verifier", "https://here"); };
  const auto away = [&] {
    const auto answer = ask();
    return !answer.ok() && answer.error().reason == Provider::kAway;
  };
  EXPECT_TRUE(away());
  EXPECT_EQ(site.asked(), 1);
  site.Answers(true);
  clock.Advance(seconds(5) - milliseconds(1));
  EXPECT_TRUE(away());
  EXPECT_EQ(site.asked(), 1) << "nobody waits";
  clock.Advance(milliseconds(1));
  EXPECT_EQ(ask().value().id_token, "abc");
  EXPECT_TRUE(ask().ok()) << "and it is as before";
  EXPECT_EQ(site.asked(), 3);
}

}  // namespace
}  // namespace faultlab::server::oidc
