#include "server/stream/stream_hub.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/clock.h"
#include "server/net/http_server.h"
#include "server/net/router.h"
#include "server/stream/viewer.h"
#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

using tests::WebSocketClient;

std::vector<StreamRow> Rows(int count, float first = 0.0F) {
  std::vector<StreamRow> rows(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].values[0] = first + static_cast<float>(i);
  return rows;
}

struct Batch {
  std::uint32_t first = 0;
  std::uint16_t count = 0;
};

Batch Header(const std::string& payload) {
  Batch batch;
  std::memcpy(&batch.count, payload.data() + 2, 2);
  std::memcpy(&batch.first, payload.data() + 4, 4);
  return batch;
}

/// A hub behind a real HTTP server: "/ws?run=NAME&command=1" joins without a code, as a guest or,
/// with "&account=ID", as an account.
class StreamHubTest : public ::testing::Test {
 protected:
  void Start() {
    hub_ = std::make_unique<StreamHub>(options_, clock_);
    ASSERT_TRUE(hub_->Start().ok());
    HttpServerOptions http;
    http.listen = "127.0.0.1:0";
    server_ = std::make_unique<HttpServer>(
        http, router_, [this](const HttpRequest& request) -> UpgradeDecision {
          const std::string run = request.Query("run").value_or("r");
          const bool command = request.Query("command").has_value();
          ViewerOwner owner;
          if (const auto account = request.Query("account")) {
            owner = {.caller = "user:" + *account, .account_id = std::stoi(*account)};
          }
          return [this, run, owner, command](UpgradedSocket socket) {
            hub_->Adopt(std::move(socket), run, owner, command);
          };
        });
    ASSERT_TRUE(server_->Start().ok());
  }
  void Open(const std::string& run = "r") {
    hub_->OpenChannel({run,
                       clock_.Monotonic(),
                       [this](ViewerId viewer, const CommandMessage& command) {
                         hub_->Reply(viewer, AckText(command, Accepted{}));
                       }},
                      "\"run\":\"" + run + "\",\"state\":\"running\"");
  }
  std::unique_ptr<WebSocketClient> Join(const std::string& query = "run=r",
                                        int receive_buffer = 0) {
    auto client =
        std::make_unique<WebSocketClient>(server_->port(), "/ws?" + query, receive_buffer);
    EXPECT_EQ(client->status(), 101);
    return client;
  }
  /// Reads until hello, so that the viewer is in the channel from here on.
  std::string Hello(WebSocketClient& client) {
    return client.ReadTextWith("\"type\":\"hello\"").value_or("");
  }
  static int CloseCode(WebSocketClient& client) {
    while (const auto frame = client.Read()) {
      if (frame->opcode == 8) return frame->close_code();
    }
    return 0;
  }

  ManualClock clock_;
  StreamHubOptions options_;
  Router router_;
  std::unique_ptr<StreamHub> hub_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(StreamHubTest, GreetsWithWhatTheRunAndTheHubKnow) {
  Start();
  Open();
  hub_->Publish("r", 0, Rows(5));
  auto client = Join("run=r&command=1");
  const std::string hello = Hello(*client);
  EXPECT_NE(hello.find(R"("run":"r","state":"running","first_index":0,"next_index":5)"),
            std::string::npos)
      << hello;
  EXPECT_NE(hello.find(R"("estimators":["swa_50",)"), std::string::npos);
  EXPECT_NE(hello.find(R"("can_command":true})"), std::string::npos);
}

TEST_F(StreamHubTest, SendsTheSameBatchToEveryViewerOfTheRunAndToNobodyElse) {
  Start();
  Open("r");
  Open("other");
  auto a = Join("run=r");
  auto b = Join("run=r");
  auto stranger = Join("run=other");
  Hello(*a);
  Hello(*b);
  Hello(*stranger);
  clock_.Advance(std::chrono::milliseconds(1500));
  hub_->Publish("r", 0, Rows(5));
  hub_->PublishText("other", R"({"type":"mark"})");
  const auto first = a->Read();
  const auto second = b->Read();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->opcode, 2);
  EXPECT_EQ(first->payload, second->payload);
  EXPECT_EQ(Header(first->payload).count, 5);
  double t_server = 0.0;
  std::memcpy(&t_server, first->payload.data() + 8, 8);
  EXPECT_DOUBLE_EQ(t_server, 1.5);
  EXPECT_EQ(stranger->Read()->payload, R"({"type":"mark"})");
}

TEST_F(StreamHubTest, GivesEverythingSinceAnIndexToWhoResumes) {
  Start();
  Open();
  for (int i = 0; i < 1000; i += 5) hub_->Publish("r", i, Rows(5, static_cast<float>(i)));
  auto client = Join();
  Hello(*client);
  client->SendText(R"({"type":"resume","since":123})");
  std::uint32_t next = 123;
  while (next < 1000) {
    const auto frame = client->Read();
    ASSERT_TRUE(frame && frame->opcode == 2);
    const Batch batch = Header(frame->payload);
    ASSERT_EQ(batch.first, next);
    float value = 0.0F;
    std::memcpy(&value, frame->payload.data() + 16, 4);
    ASSERT_EQ(value, static_cast<float>(next));
    next += batch.count;
  }
  hub_->Publish("r", 1000, Rows(5));
  EXPECT_EQ(Header(client->Read()->payload).first, 1000u) << "live again";
}

TEST_F(StreamHubTest, FillsAHoleInTheIndicesWithAbsentRows) {
  Start();
  Open();
  hub_->Publish("r", 0, Rows(2));
  hub_->Publish("r", 4, Rows(1, 4.0F));
  auto client = Join();
  Hello(*client);
  client->SendText(R"({"type":"resume","since":0})");
  const auto frame = client->Read();
  ASSERT_TRUE(frame);
  ASSERT_EQ(Header(frame->payload).count, 5);
  const auto value = [&](int row) {
    float out = 0.0F;
    std::memcpy(&out, frame->payload.data() + 16 + row * 23 * 4, 4);
    return out;
  };
  EXPECT_EQ(value(1), 1.0F);
  EXPECT_TRUE(std::isnan(value(2)));
  EXPECT_EQ(value(4), 4.0F);
}

TEST_F(StreamHubTest, DropsOldFramesOfAViewerThatStopsReadingAndTellsIt) {
  options_.socket_send_buffer_bytes = 4096;
  options_.ring_messages = 8;
  Start();
  Open();
  auto slow = Join("run=r", 4096);
  auto quick = Join("run=r");
  Hello(*slow);
  Hello(*quick);
  constexpr int kBatches = 400;
  for (int i = 0; i < kBatches; ++i) {
    hub_->Publish("r", i * 50, Rows(50));
    const auto frame = quick->Read();
    ASSERT_TRUE(frame && frame->opcode == 2);
    ASSERT_EQ(Header(frame->payload).first, static_cast<std::uint32_t>(i * 50));
  }
  EXPECT_GT(hub_->counters().messages_dropped, 0u);
  std::int64_t got = 0;
  std::uint32_t last = 0;
  std::string told;
  while (told.empty()) {
    const auto frame = slow->Read();
    ASSERT_TRUE(frame) << "a slow viewer is not thrown out";
    if (frame->opcode == 1) {
      told = frame->payload;
    } else {
      const Batch batch = Header(frame->payload);
      EXPECT_TRUE(got == 0 || batch.first > last) << "order is kept";
      last = batch.first;
      got += batch.count;
    }
  }
  EXPECT_EQ(told, "{\"type\":\"dropped\",\"samples\":" + std::to_string(kBatches * 50 - got) + "}");
}

TEST_F(StreamHubTest, ClosesAViewerThatNeverReadsTextsAndKeepsNoMoreOfThemThanItsBound) {
  options_.socket_send_buffer_bytes = 4096;
  Start();
  Open("r");
  Open("other");
  auto deaf = Join("run=r", 4096);
  Hello(*deaf);
  constexpr int kTexts = 60;  // fewer than the ring holds
  const std::string text = "{\"pad\":\"" + std::string(100'000, 'x') + "\"}";
  for (int i = 0; i < kTexts; ++i) hub_->PublishText("r", text);
  auto later = Join("run=other");
  Hello(*later);  // the hub has done all of the above
  std::size_t read = 0;
  int code = 0;
  while (const auto frame = deaf->Read()) {
    read += frame->payload.size();
    if (frame->opcode == 8) code = frame->close_code();
  }
  EXPECT_EQ(code, 1013);
  EXPECT_LE(read, text.size() + options_.text_bytes_max);
}

TEST_F(StreamHubTest, PassesCommandsOnAndRefusesThoseOfSpectators) {
  Start();
  Open();
  const std::string stop = R"({"type":"command","epoch":1,"id":"x","action":"stop"})";
  auto owner = Join("run=r&command=1");
  owner->SendText(stop);
  EXPECT_EQ(owner->ReadTextWith("ack"), R"({"type":"ack","id":"x","ok":true})");
  auto spectator = Join("run=r");
  spectator->SendText(stop);
  const auto refused = spectator->ReadTextWith("ack");
  ASSERT_TRUE(refused);
  EXPECT_NE(refused->find("forbidden"), std::string::npos);
}

TEST_F(StreamHubTest, AnswersPingsOfBothKinds) {
  Start();
  Open();
  auto client = Join();
  Hello(*client);
  clock_.Advance(std::chrono::seconds(2));
  client->SendText(R"({"type":"ping","t":7})");
  EXPECT_EQ(client->ReadTextWith("pong"), R"({"type":"pong","t":7,"server_t":2.000000})");
  client->SendFrame(0x89, "beat");
  const auto pong = client->Read();
  ASSERT_TRUE(pong);
  EXPECT_EQ(pong->opcode, 10);
  EXPECT_EQ(pong->payload, "beat");
}

TEST_F(StreamHubTest, ClosesEachKindOfGarbageWithItsCode) {
  Start();
  Open();
  const struct {
    const char* what;
    std::string bytes;
    int code;
  } cases[] = {
      {"not JSON", tests::ClientFrame(0x81, "hello?"), 1007},
      {"not UTF-8", tests::ClientFrame(0x81, "\xff\xfe"), 1007},
      {"binary", tests::ClientFrame(0x82, "\x01\x02"), 1003},
      {"huge", tests::ClientFrame(0x81, std::string(100'000, 'x')), 1009},
      {"unmasked", tests::ClientFrame(0x81, "{}", false), 1002},
      {"noise", std::string(64, '\xfe'), 1002},
  };
  for (const auto& garbage : cases) {
    auto client = Join();
    Hello(*client);
    client->Send(garbage.bytes);
    EXPECT_EQ(CloseCode(*client), garbage.code) << garbage.what;
  }
  auto witness = Join();
  Hello(*witness);
  hub_->Publish("r", 0, Rows(1));
  EXPECT_EQ(witness->Read()->opcode, 2) << "the others go on";
}

TEST_F(StreamHubTest, KeepsAViewerWithAWrongFieldAndTellsIt) {
  Start();
  Open();
  auto client = Join();
  Hello(*client);
  client->SendText(R"({"type":"resume","since":"yesterday"})");
  const auto error = client->ReadTextWith("\"error\"");
  ASSERT_TRUE(error);
  EXPECT_NE(error->find("since"), std::string::npos);
  client->SendText(R"({"type":"ping","t":1})");
  EXPECT_TRUE(client->ReadTextWith("pong"));
}

TEST_F(StreamHubTest, ClosesAViewerThatFloods) {
  Start();
  Open();
  auto client = Join();
  Hello(*client);
  std::string flood;
  for (int i = 0; i < 200; ++i) flood += tests::ClientFrame(0x8A, "");
  client->Send(flood);
  EXPECT_EQ(CloseCode(*client), 1008);
}

TEST_F(StreamHubTest, PingsTheQuietAndForgetsTheDead) {
  Start();
  Open();
  auto client = Join();
  Hello(*client);
  clock_.Advance(options_.ping_interval);
  // Read() answers the hub's ping on the way. The hub has read that answer when it answers a ping
  // that was sent after it; from then on the client says nothing.
  const auto exchange = [&client] {
    client->SendFrame(0x89, "");
    const auto pong = client->Read();
    return pong && pong->opcode == 10;
  };
  while (client->pings_answered() == 0) ASSERT_TRUE(exchange());
  ASSERT_TRUE(exchange());
  clock_.Advance(options_.silence_max);
  EXPECT_TRUE(client->WaitForClose());
}

TEST_F(StreamHubTest, ClosesWithNormalWhenTheRunHasEnded) {
  Start();
  Open();
  auto client = Join();
  Hello(*client);
  hub_->CloseChannel("r", R"({"type":"end","state":"finished"})", "\"run\":\"r\"");
  EXPECT_TRUE(client->ReadTextWith("\"end\""));
  clock_.Advance(options_.linger);
  EXPECT_EQ(CloseCode(*client), 1000);
}

TEST_F(StreamHubTest, ClosesWhoAsksForAnUnknownRun) {
  Start();
  auto client = Join("run=nothing");
  EXPECT_EQ(CloseCode(*client), 1008);
}

TEST_F(StreamHubTest, TurnsAwayMoreViewersThanItsNumber) {
  options_.viewers_max = 1;
  Start();
  Open();
  auto first = Join();
  Hello(*first);
  auto second = Join();
  EXPECT_EQ(CloseCode(*second), 1013);
}

TEST_F(StreamHubTest, OneCallerHasSoManyWindowsAndTheOthersTheRest) {
  options_.viewers_per_caller_max = 2;
  Start();
  Open();
  auto first = Join("run=r&account=1");
  auto second = Join("run=r&account=1");
  EXPECT_NE(Hello(*first), "");
  EXPECT_NE(Hello(*second), "");
  auto third = Join("run=r&account=1");
  EXPECT_EQ(CloseCode(*third), 1013);
  auto other = Join("run=r&account=2");
  EXPECT_NE(Hello(*other), "");
}

TEST_F(StreamHubTest, LeavesHalfOfThePlacesToThoseWhoHaveAnAccount) {
  options_.viewers_max = 4;
  Start();
  Open();
  auto first = Join();
  auto second = Join();
  EXPECT_NE(Hello(*first), "");
  EXPECT_NE(Hello(*second), "");
  auto third = Join();
  EXPECT_EQ(CloseCode(*third), 1013);
  auto owner = Join("run=r&account=1");
  EXPECT_NE(Hello(*owner), "");
  first.reset();
  while (hub_->counters().viewers_open > 2) std::this_thread::yield();
  auto fourth = Join();
  EXPECT_NE(Hello(*fourth), "") << "one guest has left";
}

TEST_F(StreamHubTest, TellsEveryViewerWhenTheServerStops) {
  Start();
  Open();
  auto client = Join();
  Hello(*client);
  hub_->Stop();
  EXPECT_EQ(CloseCode(*client), 1001);
}

TEST_F(StreamHubTest, NeverHoldsAPublisherUp) {
  options_.inbox_messages_max = 4;
  // Not started: nothing empties the inbox.
  hub_ = std::make_unique<StreamHub>(options_, clock_);
  hub_->OpenChannel({"r", clock_.Monotonic(), {}}, "");
  for (int i = 0; i < 100; ++i) hub_->Publish("r", i, Rows(1));
  EXPECT_EQ(hub_->counters().inbox_refused, 97u);
}

class ViewerTest : public ::testing::Test {
 protected:
  ViewerTest() {
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends_), 0);
    const int bytes = 4096;
    setsockopt(ends_[0], SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
    viewer_ = std::make_unique<Viewer>(1, ends_[0], 4, kTextBytesMax);
  }
  ~ViewerTest() override { close(ends_[1]); }
  static SharedBytes Bytes(char c) { return std::make_shared<const std::string>(3000, c); }
  std::string ReadAll() {
    std::string out;
    char bytes[65536];
    for (ssize_t got = 0; (got = read(ends_[1], bytes, sizeof bytes)) > 0;) {
      out.append(bytes, static_cast<std::size_t>(got));
    }
    return out;
  }

  static constexpr std::size_t kTextBytesMax = 10'000;
  int ends_[2] = {-1, -1};
  std::unique_ptr<Viewer> viewer_;
};

TEST_F(ViewerTest, DropsTheOldestWholeFrameAndNeverAMessage) {
  char c = 'a';
  while (viewer_->Send(Bytes(c), 5) == Viewer::Sent::kAll) ++c;
  const char first_queued = c;
  EXPECT_EQ(viewer_->Send(std::make_shared<const std::string>("TEXT"), 0), Viewer::Sent::kQueued);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(viewer_->Send(Bytes(++c), 5), Viewer::Sent::kQueued);
  }
  EXPECT_GT(viewer_->TakeDropped(), 0);
  EXPECT_EQ(viewer_->TakeDropped(), 0) << "told once";
  std::string all = ReadAll();
  while (viewer_->Flush() != Viewer::Sent::kAll) all += ReadAll();
  all += ReadAll();
  EXPECT_NE(all.find("TEXT"), std::string::npos);
  EXPECT_NE(all.find(std::string(3000, c)), std::string::npos) << "the newest is there";
  // Every frame that begins is whole.
  for (char letter = 'a'; letter <= c; ++letter) {
    const auto count = std::count(all.begin(), all.end(), letter);
    EXPECT_TRUE(count == 0 || count == 3000) << letter << ' ' << count;
  }
  EXPECT_GE(c, first_queued);
}

TEST_F(ViewerTest, IsFullWhenItLeavesARingfulOfMessagesUnread) {
  while (viewer_->Send(Bytes('x'), 0) == Viewer::Sent::kAll) {
  }
  const auto small = std::make_shared<const std::string>("y");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(viewer_->Send(small, 0), Viewer::Sent::kQueued);
  EXPECT_EQ(viewer_->Send(small, 0), Viewer::Sent::kFull);
}

TEST_F(ViewerTest, KeepsNoMoreBytesOfMessagesThanItsBound) {
  while (viewer_->Send(Bytes('x'), 0) == Viewer::Sent::kAll) {
  }
  const auto half = std::make_shared<const std::string>(kTextBytesMax / 2, 'y');
  EXPECT_EQ(viewer_->Send(half, 0), Viewer::Sent::kQueued);
  EXPECT_EQ(viewer_->Send(half, 0), Viewer::Sent::kQueued);
  EXPECT_EQ(viewer_->Send(std::make_shared<const std::string>("z"), 0), Viewer::Sent::kFull);
  EXPECT_EQ(viewer_->Send(Bytes('f'), 5), Viewer::Sent::kQueued) << "a frame is not a text";
  EXPECT_EQ(half.use_count(), 3);
  viewer_->Forget();
  EXPECT_EQ(half.use_count(), 1);
  std::string all = ReadAll();
  while (viewer_->Flush() != Viewer::Sent::kAll) all += ReadAll();
  EXPECT_EQ((all + ReadAll()).size() % 3000, 0u) << "what was half sent is whole";
}

TEST_F(ViewerTest, IsBrokenWhenThePeerIsGone) {
  close(std::exchange(ends_[1], -1));
  EXPECT_EQ(viewer_->Send(Bytes('x'), 5), Viewer::Sent::kBroken);
}

}  // namespace
}  // namespace faultlab::server
