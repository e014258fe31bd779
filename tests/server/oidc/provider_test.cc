#include "server/oidc/provider.h"

#include <gtest/gtest.h>

#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "tests/support/loopback_listener.h"

namespace faultlab::server::oidc {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Accepts connections on loopback and closes them, with its answer or without one.
class Site {
 public:
  Site() : thread_([this] { Serve(); }) {}
  ~Site() {
    listener_.Shutdown();
    thread_.join();
  }
  Site(const Site&) = delete;
  Site& operator=(const Site&) = delete;

  std::string url() const { return "http://" + listener_.address(); }
  int asked() const { return asked_; }
  void Answers(bool yes) { answers_ = yes; }

 private:
  void Serve() {
    while (true) {
      const tests::Socket client = listener_.Accept();
      if (client.fd() < 0) return;
      ++asked_;
      std::string request(8192, '\0');
      if (recv(client.fd(), request.data(), request.size(), 0) <= 0 || !answers_) continue;
      const std::string answer =
          "HTTP/1.1 200 OK\r\nContent-Length: 18\r\n\r\n{\"id_token\":\"abc\"}";
      EXPECT_GT(send(client.fd(), answer.data(), answer.size(), MSG_NOSIGNAL), 0);
    }
  }

  tests::LoopbackListener listener_;
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
