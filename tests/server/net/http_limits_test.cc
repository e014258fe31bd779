// What a client may send and how long it may take: tests the table in server/net/README.md.
#include <gtest/gtest.h>

#include <sys/socket.h>

#include <atomic>

#include "tests/server/net/http_server_fixture.h"
#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

using tests::Get;
using tests::HttpAnswer;
using tests::Post;
using tests::RawClient;

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
    RawClient idle(port, 4096);  // sends a request and does not read
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
    // An announced body that does not arrive takes nothing from others; a small body needs no
    // budget.
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
  // The idle connection has ended: its bytes are free once the server has noticed.
  HttpAnswer answer;
  for (int i = 0; i < 1000 && answer.status != 200; ++i) answer = Get(port, "/big");
  EXPECT_EQ(answer.body.size(), 8u * kMega);
}

TEST_F(HttpServerTest, WhoHoldsMostBytesMakesRoomForWhoHoldsFew) {
  constexpr int kMega = 1 << 20;
  options_.limits.waiting_bytes_max = 15 * kMega;
  const auto count = [](const HttpRequest& request) {
    HttpResponse response;
    response.body = std::to_string(request.body.size());
    return response;
  };
  Add(HttpMethod::kPost, "/upload", RunsOn::kPool, 8 * kMega, count);
  const int port = Start();
  const auto sends = [port](const char* from, int sent, int promised) {
    auto client = std::make_unique<RawClient>(port);
    client->Send("POST /upload HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: " +
                 std::string(from) + "\r\nContent-Length: " + std::to_string(promised) +
                 "\r\n\r\n" + std::string(static_cast<std::size_t>(sent), 'x'));
    return client;
  };
  const auto honest = sends("203.0.113.7", kMega, 2 * kMega);
  std::vector<std::unique_ptr<RawClient>> hoarders;
  for (const char* from : {"203.0.113.1", "203.0.113.1", "203.0.113.2", "203.0.113.2"}) {
    hoarders.push_back(sends(from, 3 * kMega, 7 * kMega));
  }
  // Only when all of it has arrived do the hoarders hold most.
  while (server_->counters().bytes_waiting < 13 * kMega) std::this_thread::yield();
  ASSERT_EQ(server_->counters().bytes_refused, 0u);
  for (int i = 0; i < 3; ++i) {
    const auto other = sends("203.0.113.5", 4 * kMega, 4 * kMega);
    const HttpAnswer answer = other->ReadAnswer();
    EXPECT_EQ(answer.status, 200) << i;
    EXPECT_EQ(answer.body, std::to_string(4 * kMega));
  }
  honest->Send(std::string(kMega, 'x'));
  EXPECT_EQ(honest->ReadAnswer().body, std::to_string(2 * kMega)) << "and this one goes on";
  EXPECT_EQ(server_->counters().bytes_refused, 1u) << "one connection of a hoarder gave way";
}

TEST_F(HttpServerTest, StrangersGiveWayToAnAccountHoweverLittleEachOfThemHolds) {
  constexpr int kMega = 1 << 20;
  options_.limits.waiting_bytes_max = 10 * kMega;
  Route route{HttpMethod::kPost, "/upload", RunsOn::kPool, 8 * kMega, [](const auto&) {
                return HttpResponse{};
              }};
  route.admit = [](const HttpRequest& request) -> Admission {
    const std::string name(request.Header("Cookie"));
    return {.caller = name, .known = !name.empty()};
  };
  router_.Add(std::move(route));
  const int port = Start();
  const auto sends = [port](const std::string& who, int sent, int promised) {
    auto client = std::make_unique<RawClient>(port);
    client->Send("POST /upload HTTP/1.1\r\nHost: localhost\r\n" + who +
                 "Content-Length: " + std::to_string(promised) + "\r\n\r\n" +
                 std::string(static_cast<std::size_t>(sent), 'x'));
    return client;
  };
  const auto slow = sends("Cookie: anna\r\n", 2 * kMega, 3 * kMega);
  std::vector<std::unique_ptr<RawClient>> strangers;
  for (int i = 0; i < 60; ++i) {
    const std::string from = "X-Forwarded-For: 203.0.113." + std::to_string(i) + "\r\n";
    strangers.push_back(sends(from, 200'000, kMega));
    if (i < 30) continue;
    const auto account = sends("Cookie: ben\r\n", 4 * kMega, 4 * kMega);
    EXPECT_EQ(account->ReadAnswer().status, 200) << i;
  }
  slow->Send(std::string(kMega, 'x'));
  EXPECT_EQ(slow->ReadAnswer().status, 200) << "no stranger pushes an account out";
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

TEST_F(HttpServerTest, RefusesConnectionsWhenAsManyAreAtWork) {
  options_.limits.connections_max = 2;
  const int port = Start();
  const std::string wait = "GET /wait HTTP/1.1\r\nHost: localhost\r\n\r\n";
  RawClient first(port);
  RawClient second(port);
  first.Send(wait);
  second.Send(wait);
  gate_.WaitForInside(2);
  RawClient third(port);
  EXPECT_EQ(third.ReadAnswer().status, 503);
  gate_.Open();
  EXPECT_EQ(first.ReadAnswer().status, 200);
  EXPECT_EQ(second.ReadAnswer().status, 200);
}

TEST_F(HttpServerTest, ConnectionsThatOnlyWaitShutNobodyOut) {
  options_.limits.connections_max = 8;
  const int port = Start();
  const std::string wait = "GET /wait HTTP/1.1\r\nHost: localhost\r\n\r\n";
  RawClient at_work(port);
  at_work.Send(wait);
  gate_.WaitForInside(1);
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 40; ++i) {
    idle.push_back(std::make_unique<RawClient>(port));
    EXPECT_EQ(Get(port, "/hello").status, 200) << i;
  }
  EXPECT_EQ(server_->counters().connections_refused, 0u);
  gate_.Open();
  EXPECT_EQ(at_work.ReadAnswer().status, 200);
}

TEST_F(HttpServerTest, ACallerWithManyRequestsWaitsForItself) {
  options_.limits.pool.threads = 1;
  options_.limits.pool.waiting_per_caller_max = 2;
  const int port = Start();
  const auto wait = [&](const std::string& from) {
    auto client = std::make_unique<RawClient>(port);
    client->Send("GET /wait HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: " + from + "\r\n\r\n");
    return client;
  };
  std::vector<std::unique_ptr<RawClient>> greedy;
  greedy.push_back(wait("203.0.113.1"));
  gate_.WaitForInside(1);
  greedy.push_back(wait("203.0.113.1"));
  greedy.push_back(wait("203.0.113.1"));
  while (server_->counters().pool_waiting < 2) std::this_thread::yield();
  const HttpAnswer refused = Get(port, "/wait", "X-Forwarded-For: 203.0.113.1\r\n");
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(refused.Header("Retry-After"), "1");
  const auto other = wait("203.0.113.2");
  while (server_->counters().pool_waiting < 3) std::this_thread::yield();
  gate_.Open();
  EXPECT_EQ(other->ReadAnswer().status, 200);
  for (const auto& client : greedy) EXPECT_EQ(client->ReadAnswer().status, 200);
}

TEST_F(HttpServerTest, HeavyWorkKeepsNobodyFromAQuickAnswer) {
  options_.limits.heavy.threads = 1;
  Add(HttpMethod::kGet, "/heavy", RunsOn::kHeavy, 0, [this](const HttpRequest&) {
    gate_.Pass();
    return HttpResponse{};
  });
  Add(HttpMethod::kGet, "/quick", RunsOn::kPool, 0, [](const HttpRequest&) {
    return HttpResponse{};
  });
  const int port = Start();
  std::vector<std::unique_ptr<RawClient>> heavy;
  for (int i = 0; i < 20; ++i) {
    heavy.push_back(std::make_unique<RawClient>(port));
    heavy.back()->Send("GET /heavy HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  gate_.WaitForInside(1);
  EXPECT_EQ(Get(port, "/quick").status, 200);
  gate_.Open();
  for (const auto& client : heavy) EXPECT_EQ(client->ReadAnswer().status, 200);
}

TEST_F(HttpServerTest, AnswersOthersWhileEveryPoolThreadIsBusy) {
  options_.limits.pool.threads = 2;
  options_.limits.pool.waiting_max = 1;
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
  // One may wait for a thread; the next is refused.
  const HttpAnswer refused = Get(port, "/wait");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.Header("Retry-After"), "1");
  gate_.Open();
  EXPECT_EQ(a.ReadAnswer().status, 200);
  EXPECT_EQ(b.ReadAnswer().status, 200);
  EXPECT_EQ(waits.ReadAnswer().status, 200);
}

}  // namespace
}  // namespace faultlab::server
