#include "server/net/http_server.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

using tests::Get;
using tests::HttpAnswer;
using tests::Post;
using tests::RawClient;
using tests::Request;

/// Keeps a handler inside until it is opened.
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

TEST_F(HttpServerTest, AnswersAGetWithSecurityHeaders) {
  const HttpAnswer answer = Get(Start(), "/hello");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, R"({"hello":"world"})");
  EXPECT_EQ(answer.Header("Content-Type"), "application/json");
  EXPECT_TRUE(answer.Header("Content-Security-Policy").starts_with("default-src 'self'"));
  EXPECT_EQ(answer.Header("Content-Security-Policy").find("unsafe"), std::string::npos);
  EXPECT_EQ(answer.Header("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(answer.Header("Cache-Control"), "no-store");
  EXPECT_FALSE(answer.Header("Date").empty());
}

TEST_F(HttpServerTest, KeepsTheConnectionAndAnswersPipelinedRequestsInOrder) {
  RawClient client(Start());
  const std::string hello = "GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n";
  client.Send(hello + "POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc" +
              hello);
  EXPECT_EQ(client.ReadAnswer().body, R"({"hello":"world"})");
  EXPECT_EQ(client.ReadAnswer().body, "abc");
  EXPECT_EQ(client.ReadAnswer().body, R"({"hello":"world"})");
}

TEST_F(HttpServerTest, ABodyIsReadOnlyForThoseWhoAreAdmitted) {
  router_.Add({HttpMethod::kPost,
               "/upload",
               RunsOn::kPool,
               20 << 20,
               [](const HttpRequest& request) {
                 HttpResponse response;
                 response.body = std::to_string(request.body.size());
                 return response;
               },
               [](const HttpRequest& request) -> Admission {
                 EXPECT_TRUE(request.body.empty());
                 if (request.Header("Cookie") == "known") return {};
                 return {.refusal = Problem(401, "unauthorized", "Unauthorized", "sign in")};
               }});
  const int port = Start();
  const std::string head = "POST /upload HTTP/1.1\r\nHost: localhost\r\nContent-Length: ";
  {
    RawClient stranger(port);
    stranger.Send(head + std::to_string(20 << 20) + "\r\n\r\n");
    EXPECT_EQ(stranger.ReadAnswer().status, 401) << "and no byte of the body was sent";
  }
  {
    RawClient stranger(port);
    stranger.Send("POST /upload HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n");
    EXPECT_EQ(stranger.ReadAnswer().status, 401);
  }
  RawClient known(port);
  known.Send(head + "100000\r\nCookie: known\r\n\r\n" + std::string(100000, 'x'));
  EXPECT_EQ(known.ReadAnswer().body, "100000");
}

TEST_F(HttpServerTest, BytesOnTheirWayAreBoundedForAllConnectionsTogether) {
  constexpr int kMega = 1 << 20;
  options_.limits.waiting_bytes_max = 10 * kMega;
  Add(HttpMethod::kGet, "/big", RunsOn::kPool, 0, [](const HttpRequest&) {
    HttpResponse response;
    response.body.assign(8 * kMega, 'x');
    return response;
  });
  const auto answers = [](const HttpRequest&) {
    HttpResponse response;
    response.body.assign(kMega, 'y');
    return response;
  };
  Add(HttpMethod::kPost, "/upload", RunsOn::kPool, 8 * kMega, answers);
  const int port = Start();
  const std::string ask = "GET /big HTTP/1.1\r\nHost: localhost\r\n\r\n";
  const auto offer = [](int bytes) {
    return "POST /upload HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + std::to_string(bytes) +
           "\r\n\r\n";
  };
  {
    RawClient idle(port, 4096);  // asks and does not read
    idle.Send(ask);
    char first = 0;
    ASSERT_EQ(recv(idle.fd(), &first, 1, MSG_PEEK), 1) << "the answer is on its way";
    const HttpAnswer refused = Get(port, "/big");
    EXPECT_EQ(refused.status, 503);
    EXPECT_EQ(refused.Header("Retry-After"), "5");
    RawClient uploader(port);
    uploader.Send(offer(4 * kMega) + std::string(4 * kMega, 'x'));
    EXPECT_EQ(uploader.ReadAnswer().status, 503) << "an upload waits for the same bytes";
    EXPECT_EQ(server_->counters().bytes_refused, 2u);
    // What is promised and does not come takes nothing from the others; what is small asks nobody.
    std::vector<std::unique_ptr<RawClient>> liars;
    for (int i = 0; i < 20; ++i) {
      liars.push_back(std::make_unique<RawClient>(port));
      liars.back()->Send(offer(8 * kMega));
    }
    EXPECT_EQ(Get(port, "/hello").status, 200);
    RawClient small(port);
    small.Send(offer(3) + "abc");
    EXPECT_EQ(small.ReadAnswer().status, 200) << "and what a request has done is told";
  }
  // The idle connection is gone: its bytes are free again once the server has noticed.
  HttpAnswer answer;
  for (int i = 0; i < 1000 && answer.status != 200; ++i) answer = Get(port, "/big");
  EXPECT_EQ(answer.body.size(), 8u * kMega);
}

TEST_F(HttpServerTest, WhatAnAdmissionHoldsIsLetGoWhenTheAnswerIsSent) {
  auto held = std::make_shared<int>(0);
  router_.Add({HttpMethod::kGet,
               "/held",
               RunsOn::kPool,
               0,
               [](const HttpRequest&) {
                 HttpResponse response;
                 response.body.assign(8 << 20, 'x');
                 return response;
               },
               [held](const HttpRequest&) -> Admission { return {.held = held}; },
               /*always_admit=*/true});
  const int port = Start();
  const auto nobody = held.use_count();
  RawClient client(port, 4096);
  client.Send("GET /held HTTP/1.1\r\nHost: localhost\r\n\r\n");
  char first = 0;
  ASSERT_EQ(recv(client.fd(), &first, 1, MSG_PEEK), 1);
  EXPECT_EQ(held.use_count(), nobody + 1);
  EXPECT_EQ(client.ReadAnswer().body.size(), 8u << 20);
  EXPECT_EQ(Get(port, "/hello").status, 200) << "the network thread has come round";
  EXPECT_EQ(held.use_count(), nobody);
}

TEST_F(HttpServerTest, AsksAgainForWhoIsNotYetAdmitted) {
  std::atomic<int> asked{0};
  router_.Add({HttpMethod::kGet,
               "/later",
               RunsOn::kPool,
               0,
               [](const HttpRequest&) { return HttpResponse{}; },
               [&](const HttpRequest&) -> Admission {
                 if (++asked == 3) return {};
                 return {.refusal = TryAgain(429, "wait", 2), .not_yet = true};
               },
               /*always_admit=*/true});
  EXPECT_EQ(Get(Start(), "/later").status, 200);
  EXPECT_EQ(asked, 3);
}

TEST_F(HttpServerTest, AnswersHeadWithTheLengthAndWithoutTheBody) {
  RawClient client(Start());
  client.Send(
      "HEAD /hello HTTP/1.1\r\nHost: localhost\r\n\r\n"
      "GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const HttpAnswer head = client.ReadAnswer(true);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.Header("Content-Length"), "17");
  EXPECT_EQ(client.ReadAnswer().body, R"({"hello":"world"})");
}

TEST_F(HttpServerTest, NamesWhatIsMissingAndWhatIsAllowed) {
  const int port = Start();
  EXPECT_EQ(Get(port, "/nowhere").status, 404);
  const HttpAnswer wrong = Request(port, "DELETE", "/hello");
  EXPECT_EQ(wrong.status, 405);
  EXPECT_EQ(wrong.Header("Allow"), "GET, HEAD");
  EXPECT_EQ(wrong.Header("Content-Type"), "application/problem+json");
}

TEST_F(HttpServerTest, RefusesTwoGigabytesBeforeTheyAreSent) {
  RawClient client(Start());
  client.Send("POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2147483648\r\n\r\n");
  const HttpAnswer answer = client.ReadAnswer();
  EXPECT_EQ(answer.status, 413);
  EXPECT_NE(answer.body.find("at most 1000 bytes"), std::string::npos);
}

TEST_F(HttpServerTest, GivesTheAnswerToAClientThatIsStillSendingItsHugeBody) {
  RawClient client(Start());
  client.Send("POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2147483648\r\n\r\n");
  client.Send(std::string(1 << 20, 'x'));
  EXPECT_EQ(client.ReadAnswer().status, 413);
}

TEST_F(HttpServerTest, HoldsTheBodyLimitForChunksToo) {
  RawClient client(Start());
  client.Send("POST /echo HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n");
  for (int i = 0; i < 12; ++i) client.Send("64\r\n" + std::string(100, 'x') + "\r\n");
  EXPECT_EQ(client.ReadAnswer().status, 413);
}

TEST_F(HttpServerTest, TakesABodyOfExactlyTheLimit) {
  const HttpAnswer answer = Post(Start(), "/echo", std::string(1000, 'x'));
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body.size(), 1000u);
}

TEST_F(HttpServerTest, InvitesABodyThatWaitsForTheWord) {
  RawClient client(Start());
  client.Send(
      "POST /echo HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nContent-Length: "
      "2\r\n\r\n");
  EXPECT_EQ(client.ReadAnswer().status, 100);
  client.Send("ok");
  EXPECT_EQ(client.ReadAnswer().body, "ok");
}

TEST_F(HttpServerTest, RefusesAHeaderThatIsTooLarge) {
  options_.limits.header_bytes_max = 2000;
  const HttpAnswer answer = Get(Start(), "/hello", "X-Long: " + std::string(4000, 'x') + "\r\n");
  EXPECT_EQ(answer.status, 431);
}

TEST_F(HttpServerTest, RefusesWhatIsNotHttp) {
  RawClient client(Start());
  client.Send("\x16\x03\x01 this is TLS or nonsense\r\n\r\n");
  EXPECT_EQ(client.ReadAnswer().status, 400);
}

TEST_F(HttpServerTest, ClosesAHeaderThatDoesNotComeToItsEnd) {
  options_.limits.header_deadline = std::chrono::milliseconds(100);
  RawClient slow(Start());
  slow.Send("GET /hello HTTP/1.1\r\nHost: localhost\r\nX-Slow: ");
  EXPECT_EQ(slow.ReadAnswer().status, 408);
  EXPECT_TRUE(slow.WaitForClose());
  EXPECT_EQ(server_->counters().deadlines_missed, 1u);
}

TEST_F(HttpServerTest, ClosesABodyThatDoesNotComeToItsEnd) {
  options_.limits.body_deadline = std::chrono::milliseconds(100);
  RawClient slow(Start());
  slow.Send("POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\nabc");
  EXPECT_EQ(slow.ReadAnswer().status, 408);
  EXPECT_TRUE(slow.WaitForClose());
}

TEST_F(HttpServerTest, ClosesASilentConnection) {
  options_.limits.idle_deadline = std::chrono::milliseconds(100);
  RawClient silent(Start());
  EXPECT_TRUE(silent.WaitForClose());
}

TEST_F(HttpServerTest, RefusesConnectionsBeyondItsNumber) {
  options_.limits.connections_max = 2;
  const int port = Start();
  RawClient first(port);
  RawClient second(port);
  const std::string hello = "GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n";
  first.Send(hello);
  second.Send(hello);
  EXPECT_EQ(first.ReadAnswer().status, 200);
  EXPECT_EQ(second.ReadAnswer().status, 200);
  RawClient third(port);
  EXPECT_EQ(third.ReadAnswer().status, 503);
}

TEST_F(HttpServerTest, AnswersOthersWhileEveryPoolThreadIsBusy) {
  options_.limits.pool_threads = 2;
  options_.limits.pool_waiting_max = 1;
  const int port = Start();
  const std::string wait = "GET /wait HTTP/1.1\r\nHost: localhost\r\n\r\n";
  RawClient a(port);
  RawClient b(port);
  a.Send(wait);
  gate_.WaitForInside(1);
  b.Send(wait);
  gate_.WaitForInside(2);
  RawClient waits(port);
  waits.Send(wait);
  while (server_->counters().pool_waiting == 0) std::this_thread::yield();
  EXPECT_EQ(Get(port, "/hello").status, 200);
  // One may wait for a thread; the next is told to come back.
  const HttpAnswer refused = Get(port, "/wait");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.Header("Retry-After"), "1");
  gate_.Open();
  EXPECT_EQ(a.ReadAnswer().status, 200);
  EXPECT_EQ(b.ReadAnswer().status, 200);
  EXPECT_EQ(waits.ReadAnswer().status, 200);
}

TEST_F(HttpServerTest, TellsNothingOfAHandlersExceptionButLogsIt) {
  const HttpAnswer answer = Get(Start(), "/throw");
  EXPECT_EQ(answer.status, 500);
  EXPECT_EQ(answer.body.find("secret"), std::string::npos);
  const std::lock_guard lock(mutex_);
  ASSERT_EQ(errors_.size(), 1u);
  EXPECT_NE(errors_[0].find("secret detail"), std::string::npos);
}

TEST_F(HttpServerTest, RefusesAForeignHostName) {
  RawClient client(Start());
  client.Send("GET /hello HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_EQ(client.ReadAnswer().status, 421);
}

TEST_F(HttpServerTest, RefusesAForeignPageThatPosts) {
  const int port = Start();
  EXPECT_EQ(Request(port, "POST", "/echo", "Origin: http://evil.example\r\n", "x").status, 403);
  EXPECT_EQ(Request(port, "POST", "/echo", "Origin: http://localhost\r\n", "x").status, 200);
}

TEST_F(HttpServerTest, BelievesAProxyOnLoopbackAboutTheClient) {
  const int port = Start();
  EXPECT_EQ(Get(port, "/peer").body, "127.0.0.1 http");
  EXPECT_EQ(
      Get(port, "/peer", "X-Forwarded-For: 10.0.0.1, 203.0.113.7\r\nX-Forwarded-Proto: https\r\n")
          .body,
      "203.0.113.7 https");
}

TEST_F(HttpServerTest, HandsAWebSocketOverWithTheBytesBehindTheHandshake) {
  RawClient client(Start());
  client.Send(
      "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\nearly");
  const HttpAnswer answer = client.ReadAnswer();
  EXPECT_EQ(answer.status, 101);
  EXPECT_EQ(answer.Header("Sec-WebSocket-Accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_EQ(client.ReadAll(), "taken");
  const std::lock_guard lock(mutex_);
  EXPECT_EQ(pending_, "early");
}

TEST_F(HttpServerTest, RefusesABadHandshakeAndAForeignOrigin) {
  const int port = Start();
  const std::string key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  const std::string upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\n";
  EXPECT_EQ(Get(port, "/ws", upgrade + key + "Sec-WebSocket-Version: 8\r\n").status, 426);
  const std::string v13 = "Sec-WebSocket-Version: 13\r\n";
  EXPECT_EQ(Get(port, "/ws", upgrade + v13 + "Sec-WebSocket-Key: short\r\n").status, 400);
  EXPECT_EQ(Get(port, "/ws", upgrade + v13 + key + "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(Get(port, "/elsewhere", upgrade + v13 + key).status, 404);
}

TEST_F(HttpServerTest, FinishesWhatRunsWhenItStops) {
  const int port = Start();
  RawClient client(port);
  RawClient idle(port);
  client.Send("GET /wait HTTP/1.1\r\nHost: localhost\r\n\r\n");
  gate_.WaitForInside(1);
  std::thread stopper([this] { server_->Stop(); });
  EXPECT_TRUE(idle.WaitForClose());
  gate_.Open();
  EXPECT_EQ(client.ReadAnswer().status, 200);
  stopper.join();
}

TEST_F(HttpServerTest, SaysWhyItCannotListen) {
  const int port = Start();
  HttpServerOptions options;
  options.listen = "127.0.0.1:" + std::to_string(port);
  HttpServer second(
      options, router_, [](const HttpRequest&) -> UpgradeDecision { return HttpResponse{}; });
  const core::Status status = second.Start();
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("in use"), std::string::npos);
}

}  // namespace
}  // namespace faultlab::server
