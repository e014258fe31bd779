#include "server/net/http_server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/server/net/http_server_fixture.h"
#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

using tests::Get;
using tests::HttpAnswer;
using tests::RawClient;
using tests::Request;

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

TEST_F(HttpServerTest, AsksAgainUntilThereIsSomethingToTell) {
  std::atomic<int> looks{0};
  Add(HttpMethod::kGet, "/later", RunsOn::kPool, 0, [&](const HttpRequest&) {
    HttpResponse response;
    if (++looks < 4) response.patience = std::chrono::seconds(60);
    if (looks == 2) response = TryAgain(503, "busy", 1);
    response.body = std::to_string(looks);
    return response;
  });
  const int port = Start();
  const HttpAnswer answer = Get(port, "/later");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, "4") << "a look for which there was no room ends nothing";
  EXPECT_EQ(Get(port, "/later").body, "5");
}

TEST_F(HttpServerTest, WhoWaitsIsCountedMakesRoomAndIsMissedWhenGone) {
  options_.limits.waits_per_caller_max = 2;
  std::atomic<int> looks{0};
  Add(HttpMethod::kGet, "/never", RunsOn::kPool, 0, [&](const HttpRequest&) {
    ++looks;
    HttpResponse response;
    response.patience = std::chrono::seconds(600);
    return response;
  });
  const int port = Start();
  const auto ask = [&](RawClient& client) {
    EXPECT_TRUE(client.Send("GET /never HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  };
  const auto wait_for = [&](std::uint64_t count) {
    while (server_->counters().waits_open != count) std::this_thread::yield();
  };
  RawClient first(port);
  ask(first);
  wait_for(1);
  {
    RawClient second(port);
    ask(second);
    wait_for(2);
    EXPECT_EQ(Get(port, "/never").status, 200) << "a third is answered soon";
  }
  wait_for(1);  // the second has left
  RawClient half(port);
  ask(half);
  wait_for(2);
  half.ShutdownWrite();
  EXPECT_EQ(half.ReadAnswer().status, 200) << "it asks no more, and reads";
  server_->Stop();
  EXPECT_TRUE(first.WaitForClose()) << "in the middle of a look, or between two";
}

TEST_F(HttpServerTest, RefusesWhatIsNotHttp) {
  RawClient client(Start());
  client.Send("\x16\x03\x01 this is TLS or nonsense\r\n\r\n");
  EXPECT_EQ(client.ReadAnswer().status, 400);
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
  // A proxy that adds a line of its own: the last line is the proxy's.
  EXPECT_EQ(
      Get(port, "/peer", "X-Forwarded-For: 127.0.0.1\r\nX-Forwarded-For: 203.0.113.9\r\n").body,
      "203.0.113.9 http");
  // One that says it where we do not look: its clients are not at this machine.
  EXPECT_EQ(Get(port, "/peer", "X-Real-IP: 127.0.0.1\r\n").body, "unknown http");
  EXPECT_EQ(Get(port, "/peer", "Forwarded: for=127.0.0.1\r\n").body, "unknown http");
}

TEST_F(HttpServerTest, TakesAnAddressAndNothingElseForTheClient) {
  const int port = Start();
  const auto client = [port](const std::string& entry) {
    const std::string body =
        Get(port, "/peer", "X-Forwarded-For: 10.0.0.1, " + entry + "\r\n").body;
    return body.substr(0, body.find(' '));
  };
  EXPECT_EQ(client("203.0.113.9:5555"), "203.0.113.9") << "its port is not its name";
  EXPECT_EQ(client("[2001:db8::1]:443"), "2001:db8::1");
  EXPECT_EQ(client("[2001:db8::1]"), "2001:db8::1");
  EXPECT_EQ(client("2001:db8::1"), "2001:db8::1");
  EXPECT_EQ(client("fe80::1%eth0"), "fe80::1");
  for (const char* entry : {"unknown",
                            "_hidden",
                            "",
                            "\"quoted\"",
                            "1.2.3",
                            "1.2.3.4:",
                            "1.2.3.4:x",
                            "1.2.3.4:123456",
                            "[1.2.3.4]:80",
                            "[2001:db8::1",
                            "[2001:db8::1]443",
                            "1.2.3.4'; --"}) {
    EXPECT_EQ(client(entry), "unknown") << entry;
  }
}

TEST_F(HttpServerTest, TellsBrowsersThatCameByHttpsToStayThere) {
  const int port = Start();
  const std::string by_https = "X-Forwarded-For: 203.0.113.7\r\nX-Forwarded-Proto: https\r\n";
  EXPECT_EQ(Get(port, "/peer", by_https).Header("Strict-Transport-Security"), "max-age=31536000");
  EXPECT_EQ(Get(port, "/peer").Header("Strict-Transport-Security"), "");
}

TEST_F(HttpServerTest, RefusesWhatTwoReadersCouldCutInTwoWays) {
  const int port = Start();
  const std::string smuggled = "GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n";
  for (const std::string& header :
       {std::string("Transfer-Encoding: identity"),
        std::string("Transfer-Encoding: chunked, identity"),
        std::string("Transfer-Encoding: gzip, chunked"),
        std::string("Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked"),
        std::string("Host: other")}) {
    RawClient client(port);
    client.Send("POST /echo HTTP/1.1\r\nHost: localhost\r\n" + header + "\r\n\r\n" + smuggled);
    EXPECT_EQ(client.ReadAnswer().status, 400) << header;
    EXPECT_TRUE(client.WaitForClose()) << header;
  }
  RawClient chunked(port);
  chunked.Send(
      "POST /echo HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: Chunked\r\n\r\n"
      "2\r\nok\r\n0\r\n\r\n");
  EXPECT_EQ(chunked.ReadAnswer().body, "ok");
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
