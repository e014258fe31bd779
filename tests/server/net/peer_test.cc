// Two servers of one lab on loopback: `near_` passes on requests for what `far_` has.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "server/clock.h"
#include "server/net/http_server.h"
#include "tests/support/loopback_listener.h"
#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using tests::Get;
using tests::HttpAnswer;
using tests::LoopbackListener;
using tests::RawClient;
using tests::Request;
using tests::Socket;
using tests::WebSocketClient;

constexpr std::size_t kMegabyte = 1 << 20;

/// The request by which a browser behind a proxy becomes a WebSocket.
std::string HandshakeOf(const std::string& address) {
  return "GET /ws?code=good HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: " + address +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
}

class PeerTest : public ::testing::Test {
 protected:
  PeerTest() {
    options_.listen = "127.0.0.1:0";
    options_.limits.pool.threads = 1;
    far_options_ = options_;
    far_router_.Add({HttpMethod::kPost, "/echo", RunsOn::kPool, kMegabyte, [](const auto& request) {
                       HttpResponse response;
                       response.status = 201;
                       response.content_type = "text/plain";
                       response.headers.emplace_back("Location", "/echo/1");
                       response.headers.emplace_back("X-Own", "stays here");
                       response.body = std::string(request.remote_address) +
                                       (request.from_peer ? " from a peer, " : " directly, ") +
                                       std::string(request.Header("Cookie")) + ", " +
                                       std::string(request.Header("X-CSRF-Token")) + ", " +
                                       std::string(request.Header("X-Other")) + ", " +
                                       std::string(request.body);
                       return response;
                     }});
    far_router_.Add({HttpMethod::kGet, "/large", RunsOn::kPool, 0, [](const auto&) {
                       HttpResponse response;
                       response.body.assign(2 * kMegabyte, 'x');
                       return response;
                     }});
    far_router_.Add({HttpMethod::kGet, "/later", RunsOn::kPool, 0, [this](const auto&) {
                       HttpResponse response;
                       if (++looks_ < 3) response.patience = std::chrono::seconds(60);
                       response.body = std::to_string(looks_);
                       return response;
                     }});
    for (const HttpMethod method : {HttpMethod::kGet, HttpMethod::kPost}) {
      near_router_.Add({method, "/*", RunsOn::kPool, kMegabyte, [this](const auto&) {
                          return AskPeers{{{"far", far_address_}}};
                        }});
    }
    near_router_.Add(
        {HttpMethod::kGet, "/of/{caller}", RunsOn::kPool, 0, [this](const HttpRequest& request) {
           return AskPeers{.peers = {PeerAddress{"far", far_address_}},
                           .caller = request.PathParameter("caller")};
         }});
    near_router_.Add(
        {HttpMethod::kGet, "/own", RunsOn::kPool, 0, [](const auto&) { return HttpResponse{}; }});
  }

  int StartFar() {
    far_ = std::make_unique<HttpServer>(
        far_options_, far_router_, [](const HttpRequest& request) -> UpgradeDecision {
          if (request.Query("code") != "good") return Problem(403, "bad_code", "No", "No.");
          return [](UpgradedSocket socket) {
            // Returns everything that it receives, until the client ends; the socket blocks again.
            std::thread([socket = std::move(socket)] {
              const auto say = [&](std::string_view text) {
                return send(socket.fd, text.data(), text.size(), MSG_NOSIGNAL) ==
                       static_cast<ssize_t>(text.size());
              };
              EXPECT_EQ(fcntl(socket.fd, F_SETFL, 0), 0);
              bool open = say("early") && say(socket.pending);
              std::array<char, 4096> bytes;
              while (open) {
                const ssize_t got = recv(socket.fd, bytes.data(), bytes.size(), 0);
                open = got > 0 && say({bytes.data(), static_cast<std::size_t>(got)});
              }
              close(socket.fd);
            }).detach();
          };
        });
    far_->SetHopSeal(ForwardingSeal("secret", "far"));
    EXPECT_TRUE(far_->Start().ok());
    far_address_ = far_->address();
    return far_->port();
  }
  int StartNear() {
    near_ = std::make_unique<HttpServer>(
        options_, near_router_, [this](const HttpRequest&) -> UpgradeDecision {
          return PeerAddress{"far", far_address_};
        });
    near_->SetHopSeal(ForwardingSeal("secret", "near"));
    EXPECT_TRUE(near_->Start().ok());
    return near_->port();
  }

  HttpServerOptions options_;
  HttpServerOptions far_options_;
  Router far_router_;
  Router near_router_;
  std::string far_address_ = "127.0.0.1:1";  ///< an address where nobody listens
  std::atomic<int> looks_{0};
  std::unique_ptr<HttpServer> far_;
  std::unique_ptr<HttpServer> near_;
};

TEST_F(PeerTest, GetsTheRequestAsItCameAndItsAnswerGoesBack) {
  StartFar();
  const HttpAnswer answer = Request(StartNear(),
                                    "POST",
                                    "/echo?x=%20",
                                    "cookie: a=b\r\nX-CSRF-Token: t\r\nX-Other: dropped\r\n"
                                    "X-Forwarded-For: 203.0.113.9\r\n",
                                    "body");
  EXPECT_EQ(answer.status, 201);
  EXPECT_EQ(answer.body, "203.0.113.9 from a peer, a=b, t, , body");
  EXPECT_EQ(answer.Header("Content-Type"), "text/plain");
  EXPECT_EQ(answer.Header("Location"), "/echo/1");
  EXPECT_EQ(answer.Header("X-Own"), "");
  EXPECT_EQ(near_->counters().passed_on, 1u);
}

TEST_F(PeerTest, HeadGetsTheLengthOfTheFarAnswer) {
  StartFar();
  const HttpAnswer answer = Request(StartNear(), "HEAD", "/large");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.Header("Content-Length"), std::to_string(2 * kMegabyte));
}

TEST_F(PeerTest, HopsThatNoServerOfTheLabSealedAreRefused) {
  const int far = StartFar();
  const int near = StartNear();
  HttpRequest request;
  request.method = HttpMethod::kPost;
  request.target = "/echo";
  request.body = "body";
  const auto hop = [&](const ForwardingSeal& seal, std::string_view receiver) {
    return "X-Faultlab-Hop: " +
           seal.Seal({"127.0.0.1", false}, receiver, request, SystemClock().Wall()) + "\r\n";
  };
  const auto ask = [](int port, const std::string& header) {
    return Request(port, "POST", "/echo", header, "body");
  };
  const ForwardingSeal stranger("guessed", "near");
  for (const int port : {near, far}) {
    const HttpAnswer answer = ask(port, hop(stranger, port == far ? "far" : "near"));
    EXPECT_EQ(answer.status, 403);
    EXPECT_NE(answer.body.find("foreign_hop"), std::string::npos) << answer.body;
  }
  EXPECT_EQ(ask(far, hop(ForwardingSeal("secret", "near"), "near")).status, 403)
      << "of another server";
  const std::string good = hop(ForwardingSeal("secret", "near"), "far");
  EXPECT_EQ(ask(far, good).status, 201);
  EXPECT_EQ(ask(far, good).status, 403) << "said again";
  EXPECT_EQ(
      Request(far, "POST", "/echo", hop(ForwardingSeal("secret", "near"), "far"), "more").status,
      403)
      << "with another body";
  EXPECT_EQ(near_->counters().passed_on, 0u);
  // A proxy's header cannot repair an invalid hop, and cannot override a valid one.
  EXPECT_EQ(ask(far, hop(stranger, "far") + "X-Forwarded-For: 10.1.1.1\r\n").status, 403);
  const HttpAnswer both =
      ask(far, hop(ForwardingSeal("secret", "near"), "far") + "X-Forwarded-For: 10.1.1.1\r\n");
  EXPECT_EQ(both.body.substr(0, 9), "127.0.0.1");
}

TEST_F(PeerTest, AForeignPageIsForeignAtBoth) {
  StartFar();
  const int near = StartNear();
  EXPECT_EQ(Request(near, "POST", "/echo", "Origin: http://evil.example\r\n", "x").status, 403);
  EXPECT_EQ(Request(near, "POST", "/echo", "Origin: http://localhost\r\n", "x").status, 201);
  far_.reset();
  far_options_.allowed_hosts = {"lab.example"};
  StartFar();
  EXPECT_EQ(Request(near, "POST", "/echo", "", "x").status, 201) << "localhost is every server's";
}

TEST_F(PeerTest, ThatIsNotThereIsSaidAtOnce) {
  const HttpAnswer answer = Get(StartNear(), "/large");
  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.Header("Retry-After"), "3");
  EXPECT_NE(answer.body.find("Server 'far' has what this is about and cannot be reached"),
            std::string::npos)
      << answer.body;
  EXPECT_EQ(near_->counters().peers_silent, 1u);
  far_address_.clear();
  EXPECT_NE(Get(near_->port(), "/large").body.find("set member_address"), std::string::npos);
}

TEST_F(PeerTest, ThatIsSilentTakesNoPoolThreadAndItsCallersAreBounded) {
  LoopbackListener silent;
  far_address_ = silent.address();
  options_.limits.peers.waiting_max = 2;
  const int near = StartNear();
  RawClient first(near);
  RawClient second(near);
  for (RawClient* client : {&first, &second}) {
    client->Send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
    silent.Accept();  // closed after the request arrived, which is reported at once
  }
  EXPECT_EQ(first.ReadAnswer().status, 503);
  EXPECT_EQ(second.ReadAnswer().status, 503);

  RawClient third(near);
  RawClient fourth(near);
  third.Send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const Socket held_third = silent.Accept();
  fourth.Send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const Socket held_fourth = silent.Accept();
  // Both wait, and the one pool thread is free.
  EXPECT_EQ(Get(near, "/own").status, 200);
  const HttpAnswer fifth = Get(near, "/large");
  EXPECT_EQ(fifth.status, 503);
  EXPECT_NE(fifth.body.find("Too many requests wait for server 'far'"), std::string::npos);
  // Requests that change something have places of their own.
  RawClient stops(near);
  stops.Send("POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
  const Socket held_stop = silent.Accept();
}

TEST_F(PeerTest, OneCallerHasAPartOfWhatMayWaitForAPeer) {
  LoopbackListener silent;
  far_address_ = silent.address();
  options_.limits.peers.waiting_per_caller_max = 1;
  options_.limits.peers.answer_deadline = std::chrono::minutes(1);
  near_router_.Add({HttpMethod::kGet, "/list", RunsOn::kPool, 0, [this](const auto&) {
                      AskPeers ask{.peers = {PeerAddress{"far", far_address_}}, .caller = "anna"};
                      ask.join = [](const auto&) { return HttpResponse{}; };
                      return ask;
                    }});
  const int near = StartNear();
  RawClient anna(near);
  anna.Send("GET /of/anna HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const Socket held = silent.Accept();
  const HttpAnswer more = Get(near, "/of/anna");
  EXPECT_EQ(more.status, 429);
  EXPECT_EQ(more.Header("Retry-After"), "1");
  EXPECT_EQ(Get(near, "/list").status, 429) << "a list waits as well";

  RawClient mila(near);
  mila.Send("GET /of/mila HTTP/1.1\r\nHost: localhost\r\n\r\n");
  silent.Accept();  // closed after the request arrived
  EXPECT_NE(mila.ReadAnswer().body.find("Server 'far' does not answer"), std::string::npos);
}

TEST_F(PeerTest, ThatIsSilentIsGivenUp) {
  LoopbackListener silent;
  far_address_ = silent.address();
  options_.limits.peers.answer_deadline = milliseconds(50);
  options_.limits.peers.change_deadline = milliseconds(50);
  const int near = StartNear();
  EXPECT_NE(Get(near, "/large").body.find("Server 'far' does not answer"), std::string::npos);
  const HttpAnswer change = Request(near, "POST", "/echo", "", "x");
  EXPECT_EQ(change.status, 503);
  EXPECT_NE(change.body.find("it may be done. Look before you ask again."), std::string::npos)
      << change.body;
}

TEST_F(PeerTest, AnAnswerThatIsTooLargeIsNotKept) {
  options_.limits.peers.answer_bytes_max = kMegabyte;
  StartFar();
  EXPECT_EQ(Get(StartNear(), "/large").status, 503);
}

TEST_F(PeerTest, SeveralAnswersAreMadeOne) {
  StartFar();
  near_router_.Add({HttpMethod::kPost, "/joined", RunsOn::kPool, kMegabyte, [this](const auto&) {
                      AskPeers ask{{{"gone", "127.0.0.1:1"}, {"far", far_address_}}};
                      ask.join = [](std::vector<core::Result<HttpResponse>> answers) {
                        HttpResponse response;
                        for (const auto& answer : answers) {
                          response.body += answer.ok() ? "one " : "none ";
                        }
                        return response;
                      };
                      return ask;
                    }});
  far_router_.Add({HttpMethod::kPost, "/joined", RunsOn::kPool, kMegabyte, [](const auto&) {
                     return HttpResponse{};
                   }});
  EXPECT_EQ(Request(StartNear(), "POST", "/joined", "", "x").body, "none one ");
}

TEST_F(PeerTest, AWebSocketGoesThroughBothWaysAndEndsForBoth) {
  StartFar();
  const int near = StartNear();
  WebSocketClient client(near, "/ws?code=good");
  ASSERT_EQ(client.status(), 101);
  EXPECT_EQ(near_->counters().tunnels_open, 1u);
  // More than all buffers between them can hold, read only after all of it was sent.
  const std::string sent(8 * kMegabyte, 'w');
  std::thread sender([&] {
    EXPECT_TRUE(client.Send(sent));
    client.ShutdownWrite();
  });
  const std::string back = client.ReadAll();
  sender.join();
  EXPECT_EQ(back.substr(0, 5), "early");
  EXPECT_EQ(back.size(), 5 + sent.size());
  EXPECT_EQ(back.substr(5), sent);
  while (near_->counters().tunnels_open > 0) std::this_thread::yield();
}

TEST_F(PeerTest, ItIsTheServerThatWasAskedThatWaits) {
  StartFar();
  const HttpAnswer answer = Get(StartNear(), "/later");
  EXPECT_EQ(answer.body, "3");
  EXPECT_EQ(answer.Header("Faultlab-Patience"), "") << "of the servers among themselves";
}

TEST_F(PeerTest, AWebSocketThatIsRefusedThereIsRefusedHere) {
  StartFar();
  WebSocketClient client(StartNear(), "/ws?code=bad");
  EXPECT_EQ(client.status(), 403);
  EXPECT_EQ(near_->counters().tunnels_open, 0u);
}

TEST_F(PeerTest, WebSocketsToPeersHaveALimitOfTheirOwn) {
  options_.limits.peers.tunnels_max = 1;
  options_.limits.connections_max = 3;
  StartFar();
  const int near = StartNear();
  WebSocketClient first(near, "/ws?code=good");
  ASSERT_EQ(first.status(), 101);
  WebSocketClient second(near, "/ws?code=good");
  EXPECT_EQ(second.status(), 503);
  const RawClient idle(near);
  // With `second`, which is still being answered, and `idle` this is the third.
  EXPECT_EQ(Get(near, "/own").status, 200) << "a tunnel takes no place of a request";
}

TEST_F(PeerTest, OneAddressHasHalfOfTheWebSocketsToPeers) {
  options_.limits.peers.tunnels_max = 2;
  StartFar();
  const int near = StartNear();
  WebSocketClient first(near, "/ws?code=good");
  ASSERT_EQ(first.status(), 101);
  WebSocketClient second(near, "/ws?code=good");
  EXPECT_EQ(second.status(), 429);
  RawClient other(near);
  other.Send(HandshakeOf("203.0.113.9"));
  EXPECT_EQ(other.ReadAnswer().status, 101);
}

TEST_F(PeerTest, HandshakesOfStrangersTakeNoPlaceOfTunnelsAndRequests) {
  LoopbackListener silent;
  far_address_ = silent.address();
  options_.limits.peers.waiting_max = 2;
  options_.limits.peers.answer_deadline = std::chrono::minutes(1);
  const int near = StartNear();
  RawClient stranger(near);
  stranger.Send(HandshakeOf("203.0.113.9"));
  const Socket held_stranger = silent.Accept();
  RawClient again(near);
  again.Send(HandshakeOf("203.0.113.9"));
  EXPECT_EQ(again.ReadAnswer().status, 429);
  RawClient another(near);
  another.Send(HandshakeOf("203.0.113.10"));
  const Socket held_another = silent.Accept();
  RawClient third(near);
  third.Send(HandshakeOf("203.0.113.11"));
  EXPECT_EQ(third.ReadAnswer().status, 503);
  EXPECT_EQ(near_->counters().tunnels_open, 0u);

  RawClient student(near);
  student.Send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  silent.Accept();  // closed after the request arrived
  EXPECT_NE(student.ReadAnswer().body.find("Server 'far' does not answer"), std::string::npos);
}

TEST_F(PeerTest, ASilentTunnelIsClosed) {
  options_.limits.peers.tunnel_silence = milliseconds(50);
  options_.limits.idle_deadline = milliseconds(50);  // interval of the checks of deadlines
  StartFar();
  WebSocketClient client(StartNear(), "/ws?code=good");
  ASSERT_EQ(client.status(), 101);
  EXPECT_TRUE(client.WaitForClose());
}

TEST_F(PeerTest, StoppingClosesTunnels) {
  StartFar();
  WebSocketClient client(StartNear(), "/ws?code=good");
  ASSERT_EQ(client.status(), 101);
  near_->Stop();
  EXPECT_TRUE(client.WaitForClose());
}

}  // namespace
}  // namespace faultlab::server
