// Clients that send half a request, or read half an answer, use up neither memory nor the places of
// others.
#include <gtest/gtest.h>

#include <sys/socket.h>

#include <atomic>
#include <thread>

#include "server/spool.h"
#include "tests/server/net/http_server_fixture.h"
#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

using tests::Get;
using tests::HttpAnswer;
using tests::RawClient;
using Clients = std::vector<std::unique_ptr<RawClient>>;

constexpr const char* kChunked =
    "POST /echo HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n";

std::unique_ptr<RawClient> Sends(int port, const std::string& bytes) {
  auto client = std::make_unique<RawClient>(port);
  client->Send(bytes);
  return client;
}

std::string HalfABody(const std::string& from) {
  return "POST /echo HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: " + from +
         "\r\nContent-Length: 100\r\n\r\n{";
}

/// Whether the server has closed its end, with or without an answer.
bool Ended(const RawClient& client) {
  char byte = 0;
  return recv(client.fd(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) >= 0;
}

TEST_F(HttpServerTest, WhatIsNoBodyOfAChunkedRequestIsBounded) {
  const int port = Start();
  const std::string much(200'000, 'a');
  std::string extensions;  // each chunk is small, its extension is large
  for (int i = 0; i < 20; ++i) {
    extensions += "1;" + std::string(15'000, 'e') + "\r\nx\r\n";
  }
  std::string trailers = "1\r\nx\r\n0\r\n";
  for (int i = 0; i < 2'000; ++i) trailers += "X-Trailer-" + std::to_string(i) + ": yes\r\n";
  for (const std::string& body : {"20;" + much,
                                  "1\r\n{\r\n0\r\nX-T: " + much,
                                  "1\r\n{\r\n0\r\n" + much + ": yes\r\n\r\n",
                                  std::string(200'000, '0'),
                                  extensions,
                                  trailers}) {
    RawClient client(port);
    client.Send(kChunked + body);
    EXPECT_EQ(client.ReadAnswer().status, 400) << body.substr(0, 24);
  }
}

TEST_F(HttpServerTest, ABodyMayComeInChunksOfOneByteWithATrailer) {
  Add(HttpMethod::kPost, "/long", RunsOn::kPool, 1 << 20, [](const HttpRequest& request) {
    HttpResponse response;
    response.body = std::to_string(request.body.size());
    return response;
  });
  constexpr int kBytes = 50'000;
  std::string body;
  for (int i = 0; i < kBytes; ++i) body += "1\r\nx\r\n";
  RawClient client(Start());
  client.Send("POST /long HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n" +
              body + "0;last=yes\r\nX-Checksum: 1\r\n\r\n");
  EXPECT_EQ(client.ReadAnswer().body, std::to_string(kBytes));
}

TEST_F(HttpServerTest, HalfSentBodiesOfOneClientShutNobodyOut) {
  options_.limits.connections_max = 8;
  const int port = Start();
  const auto honest = Sends(port, HalfABody("203.0.113.7"));
  EXPECT_EQ(Get(port, "/hello").status, 200) << "the network thread has come round";
  Clients flood;
  for (int i = 0; i < 40; ++i) {
    flood.push_back(Sends(port, HalfABody("203.0.113.9")));
    EXPECT_EQ(Get(port, "/hello", "X-Forwarded-For: 203.0.113.5\r\n").status, 200) << i;
  }
  EXPECT_EQ(server_->counters().connections_refused, 0u);
  honest->Send(std::string(99, 'x'));
  EXPECT_EQ(honest->ReadAnswer().status, 200) << "the slow one that has few goes on";
}

TEST_F(HttpServerTest, HalfSentHeadersShutNobodyOut) {
  options_.limits.connections_max = 8;
  const int port = Start();
  Clients flood;
  for (int i = 0; i < 40; ++i) {
    flood.push_back(Sends(port, "GET /hello HTTP/1.1\r\nHost: loc"));
    EXPECT_EQ(Get(port, "/hello").status, 200) << i;
  }
  EXPECT_EQ(server_->counters().connections_refused, 0u);
}

TEST_F(HttpServerTest, AnswersThatOneClientDoesNotTakeShutNobodyOut) {
  options_.limits.connections_max = 8;
  Add(HttpMethod::kGet, "/big", RunsOn::kPool, 0, [](const HttpRequest&) {
    HttpResponse response;
    response.body.assign(8 << 20, 'x');
    return response;
  });
  const int port = Start();
  Clients flood;
  for (int i = 0; i < 16; ++i) {
    flood.push_back(std::make_unique<RawClient>(port, 4096));
    flood.back()->Send(
        "GET /big HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: 203.0.113.9\r\n\r\n");
    char first = 0;
    ASSERT_EQ(recv(flood.back()->fd(), &first, 1, MSG_PEEK), 1) << "the answer is on its way";
    EXPECT_EQ(Get(port, "/hello", "X-Forwarded-For: 203.0.113.5\r\n").status, 200) << i;
  }
  EXPECT_EQ(server_->counters().connections_refused, 0u);
}

TEST_F(HttpServerTest, AClientMaySendSoManyBodiesSlowlyAndNoMore) {
  constexpr int kBodiesMax = 64;
  const int port = Start();
  Clients slow;
  for (int i = 0; i < kBodiesMax; ++i) slow.push_back(Sends(port, HalfABody("203.0.113.9")));
  EXPECT_EQ(Get(port, "/hello").status, 200) << "the network thread has come round";
  const auto one_more = Sends(port, HalfABody("203.0.113.9"));
  const HttpAnswer refused = one_more->ReadAnswer();
  EXPECT_EQ(refused.status, 429);
  EXPECT_FALSE(refused.Header("Retry-After").empty());
  const auto other = Sends(port, HalfABody("203.0.113.5"));
  other->Send(std::string(99, 'x'));
  EXPECT_EQ(other->ReadAnswer().status, 200);
  const auto whole = Sends(port, HalfABody("203.0.113.9") + std::string(99, 'x'));
  EXPECT_EQ(whole->ReadAnswer().status, 200) << "what comes along with its header waits for nobody";
  for (const auto& client : slow) EXPECT_FALSE(Ended(*client));
  slow.front()->Send(std::string(99, 'x'));
  EXPECT_EQ(slow.front()->ReadAnswer().status, 200);
  const auto next = Sends(port, HalfABody("203.0.113.9"));
  next->Send(std::string(99, 'x'));
  EXPECT_EQ(next->ReadAnswer().status, 200);
}

/// Two answers of 32 MB: from memory, and piece by piece.
class TakenSlowlyTest : public HttpServerTest, public ::testing::WithParamInterface<const char*> {
 protected:
  static constexpr std::size_t kBytes = 32 << 20;

  TakenSlowlyTest() {
    options_.limits.look_every = std::chrono::milliseconds(10);
    Add("/memory", [](const HttpRequest&) {
      HttpResponse response;
      response.body.assign(kBytes, 'x');
      return response;
    });
    Add("/spool", [](const HttpRequest&) {
      const auto spool = std::make_shared<Spool>(DiskReserve{});
      const std::string part(1 << 20, 'x');
      for (std::size_t i = 0; i < kBytes / part.size(); ++i) spool->Append(part);
      HttpResponse response;
      response.spool = spool;
      return response;
    });
  }
  void Add(const std::string& pattern, std::function<RouteAnswer(const HttpRequest&)> handle) {
    Route route{HttpMethod::kGet, pattern, RunsOn::kPool, 0, std::move(handle)};
    route.still_may = [this](const HttpRequest& request) {
      EXPECT_EQ(request.Header("Cookie"), "mine");
      ++asked_;
      asked_.notify_all();
      if (may_) return true;
      refused_ = true;
      refused_.notify_all();
      return false;
    };
    router_.Add(std::move(route));
  }
  std::unique_ptr<RawClient> Begin(int receive_buffer_bytes = 4096) {
    auto client = std::make_unique<RawClient>(Start(), receive_buffer_bytes);
    client->Send(std::string("GET ") + GetParam() +
                 " HTTP/1.1\r\nHost: localhost\r\nCookie: mine\r\n\r\n");
    return client;
  }
  void WaitForAnother() {
    const int before = asked_;
    asked_.wait(before);
  }

  std::atomic<int> asked_{0};
  std::atomic<bool> may_{true};
  std::atomic<bool> refused_{false};
};

TEST_P(TakenSlowlyTest, AnAnswerEndsWithTheRightToIt) {
  const auto client = Begin();
  WaitForAnother();
  may_ = false;
  refused_.wait(false);
  EXPECT_LT(client->ReadAll().size(), kBytes / 2);
  EXPECT_EQ(Get(server_->port(), "/hello").status, 200);
}

TEST_P(TakenSlowlyTest, OfAnAnswerThatWentFastLittleIsInTheKernelWhenTheRightToItEnds) {
  const auto client = Begin(1 << 18);
  std::string piece(64 << 10, '\0');
  for (std::size_t read = 0; read < kBytes / 2;) {
    const ssize_t got = recv(client->fd(), piece.data(), piece.size(), 0);
    ASSERT_GT(got, 0);
    read += static_cast<std::size_t>(got);
  }
  for (int i = 0; i < 3; ++i) WaitForAnother();  // both kernels are full
  may_ = false;
  refused_.wait(false);
  EXPECT_LT(client->ReadAll().size(), 1u << 20);
}

TEST_P(TakenSlowlyTest, AnAnswerIsWholeWhileTheRightHolds) {
  const auto client = Begin();
  for (int i = 0; i < 3; ++i) WaitForAnother();
  EXPECT_EQ(client->ReadAnswer().body, std::string(kBytes, 'x'));
}

INSTANTIATE_TEST_SUITE_P(Answers, TakenSlowlyTest, ::testing::Values("/memory", "/spool"));

TEST_F(HttpServerTest, ALaneThatIsStuckLeavesThreadsToOthers) {
  options_.limits.outside = {
      .threads = 3, .waiting_max = 8, .waiting_per_caller_max = 8, .threads_per_lane = 2};
  Route route{
      HttpMethod::kGet, "/ask/{site}", RunsOn::kOutside, 0, [this](const HttpRequest& request) {
        if (request.PathParameter("site") == "stuck") gate_.Pass();
        return HttpResponse{};
      }};
  route.lane = "site";
  router_.Add(std::move(route));
  const int port = Start();
  Clients stuck;
  for (int i = 0; i < 6; ++i) {
    stuck.push_back(Sends(port, "GET /ask/stuck HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    if (i == 1) gate_.WaitForInside(2);  // the rest waits
  }
  while (server_->counters().pool_waiting < 4) std::this_thread::yield();
  EXPECT_EQ(Get(port, "/ask/stuck").status, 503) << "half of what may wait waits";
  for (int i = 0; i < 10; ++i) EXPECT_EQ(Get(port, "/ask/well").status, 200);
  gate_.Open();
  for (const auto& client : stuck) EXPECT_EQ(client->ReadAnswer().status, 200);
}

}  // namespace
}  // namespace faultlab::server
