#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>
#include <cstring>
#include <set>
#include <string>

#include "server/clock.h"
#include "server/stream/client_message.h"
#include "server/stream/frame_codec.h"
#include "server/stream/stream_tokens.h"
#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

template <typename T>
T At(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST(FrameCodec, LaysBytesOutAsTheContractSays) {
  core::Frame frame;
  frame.sample = {7, 0.07, 2.0, 4.5, core::kAbsent, 0.25, 1800.0};
  frame.estimates[0].theta = {2.1, -1.1, -0.57};
  frame.estimates[0].status = core::EstimateStatus::kWeak;
  frame.estimates[5].theta = {2.4, 0.04, 0.018};
  frame.estimates[5].status = core::EstimateStatus::kInvalid;
  const StreamRow rows[] = {MakeRow(frame), MakeRow(frame)};
  const std::string bytes = EncodeFrameMessage(rows, 7, 1.5);
  ASSERT_EQ(bytes.size(), 16u + 2 * (23 * 4 + 8));
  EXPECT_EQ(bytes[0], 1);
  EXPECT_EQ(bytes[1], 1);
  EXPECT_EQ(At<std::uint16_t>(bytes, 2), 2);
  EXPECT_EQ(At<std::uint32_t>(bytes, 4), 7u);
  EXPECT_EQ(At<double>(bytes, 8), 1.5);
  EXPECT_EQ(At<float>(bytes, 16), 2.0F);
  EXPECT_EQ(At<float>(bytes, 20), 4.5F);
  EXPECT_TRUE(std::isnan(At<float>(bytes, 24))) << "an absent channel";
  EXPECT_EQ(At<float>(bytes, 36), 2.1F);
  EXPECT_TRUE(std::isnan(At<float>(bytes, 16 + 4 * 20))) << "an estimate that is not available";
  EXPECT_EQ(At<float>(bytes, 16 + 23 * 4), 2.0F) << "the second row";
  const std::size_t statuses = 16 + 2 * 23 * 4;
  EXPECT_EQ(bytes[statuses], 1);
  EXPECT_EQ(bytes[statuses + 5], 3);
  EXPECT_EQ(bytes[statuses + 6], 0);
}

TEST(FrameCodec, NamesEveryChannelOnce) {
  const auto& names = ChannelNames();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 23u);
  EXPECT_EQ(names[0], "uc_v");
  EXPECT_EQ(names[5], "swa_50.b0d");
  EXPECT_EQ(names[22], "sia_500_20.a1");
}

TEST(ClientMessage, ReadsACommand) {
  const auto parsed = ParseClientMessage(
      R"({"type":"command","epoch":3,"id":"a7","action":"set","component":"R1","value":100})");
  ASSERT_TRUE(parsed.ok()) << parsed.error().message;
  const auto& command = std::get<CommandMessage>(parsed.value());
  EXPECT_EQ(command.epoch, hardware::Epoch{3});
  EXPECT_EQ(command.id, "a7");
  EXPECT_EQ(command.action, ViewerAction::kSet);
  EXPECT_EQ(command.component, "R1");
  EXPECT_EQ(command.value, 100.0);
}

TEST(ClientMessage, ReadsPingAndResume) {
  EXPECT_EQ(std::get<PingMessage>(ParseClientMessage(R"({"type":"ping","t":1.5})").value()).t, 1.5);
  EXPECT_EQ(
      std::get<ResumeMessage>(ParseClientMessage(R"({"type":"resume","since":9})").value()).since,
      9);
}

TEST(ClientMessage, RefusesByTheNameOfTheField) {
  const struct {
    const char* text;
    const char* field;
  } cases[] = {
      {R"({})", "type"},
      {R"({"type":"shutdown"})", "type"},
      {R"({"type":"ping"})", "t"},
      {R"({"type":"ping","t":1e999})", "t"},
      {R"({"type":"ping","t":1,"extra":2})", "extra"},
      {R"({"type":"resume","since":-1})", "since"},
      {R"({"type":"resume","since":1.5})", "since"},
      {R"({"type":"command","id":"1","action":"stop"})", "epoch"},
      {R"({"type":"command","epoch":-1,"id":"1","action":"stop"})", "epoch"},
      {R"({"type":"command","epoch":1,"action":"stop"})", "id"},
      {R"({"type":"command","epoch":1,"id":[],"action":"stop"})", "id"},
      {R"({"type":"command","epoch":1,"id":"1","action":"explode"})", "action"},
      {R"({"type":"command","epoch":1,"id":"1","action":"stop","component":"R1"})", "component"},
      {R"({"type":"command","epoch":1,"id":"1","action":"set","component":"","value":1})",
       "component"},
      {R"({"type":"command","epoch":1,"id":"1","action":"set","component":"R1"})", "value"},
      {R"({"type":"command","epoch":1,"id":"1","action":"set","component":"R1","value":0})",
       "value"},
      {R"({"type":"command","epoch":1,"id":"1","action":"set","component":"R1","value":"1"})",
       "value"},
  };
  for (const auto& wrong : cases) {
    const auto parsed = ParseClientMessage(wrong.text);
    ASSERT_FALSE(parsed.ok()) << wrong.text;
    EXPECT_EQ(parsed.error().field, wrong.field) << wrong.text;
    EXPECT_FALSE(parsed.error().message.empty());
  }
}

TEST(ClientMessage, CallsOtherBytesGarbage) {
  for (const std::string& text : {std::string(),
                                  std::string("hello"),
                                  std::string("[1,2]"),
                                  std::string("{\"type\":"),
                                  std::string(100, '['),
                                  std::string(5000, ' ')}) {
    const auto parsed = ParseClientMessage(text);
    ASSERT_FALSE(parsed.ok());
    EXPECT_TRUE(parsed.error().field.empty()) << text.substr(0, 20);
  }
}

TEST(AckText, EchoesTheIdAsItCame) {
  CommandMessage command;
  command.id = "say \"hi\"";
  EXPECT_EQ(AckText(command, Accepted{}), R"({"type":"ack","id":"say \"hi\"","ok":true})");
  command.id = "12";
  command.id_is_number = true;
  EXPECT_EQ(AckText(command, core::Error{core::ErrorCode::kStale, "reload", {}}),
            R"({"type":"ack","id":12,"ok":false,"error":{"code":"stale","message":"reload",)"
            R"("reason":"stale","parameters":{}}})");
}

TEST(AckText, SaysUntilWhenAChangeWaits) {
  CommandMessage command;
  command.id = "7";
  const boost::json::value ack = boost::json::parse(AckText(command, Accepted{5.0}));
  EXPECT_EQ(ack.at("ok"), true);
  EXPECT_EQ(ack.at("waits_until_s").to_number<double>(), 5.0);
}

TEST(StreamTokens, OpenOnceAndOnlyForThirtySeconds) {
  ManualClock clock;
  StreamTokens tokens(clock);
  const std::string code = tokens.Issue({"run-1", {}, true});
  EXPECT_GE(code.size(), 26u) << "128 bits";
  const auto grant = tokens.Redeem(code);
  ASSERT_TRUE(grant);
  EXPECT_EQ(grant->run, "run-1");
  EXPECT_TRUE(grant->can_command);
  EXPECT_FALSE(tokens.Redeem(code)) << "used";
  const std::string late = tokens.Issue({"run-1", {}, true});
  clock.Advance(std::chrono::seconds(30));
  EXPECT_FALSE(tokens.Redeem(late)) << "old";
  EXPECT_FALSE(tokens.Redeem("")) << "unknown";
}

TEST(StreamTokens, OneCallerCannotPushOutTheCodesOfOthers) {
  ManualClock clock;
  StreamTokens tokens(clock);
  const std::string code = tokens.Issue({"run-1", {.caller = "user:1"}, true});
  std::vector<std::string> flood;
  for (int i = 0; i < 25'000; ++i) flood.push_back(tokens.Issue({"r", {.caller = "guest"}, false}));
  EXPECT_TRUE(tokens.Redeem(code));
  EXPECT_TRUE(tokens.Redeem(flood.back()));
  EXPECT_FALSE(tokens.Redeem(flood.front()));
}

TEST(StreamTokens, ManyGuestsCannotPushOutTheCodesOfAccounts) {
  ManualClock clock;
  StreamTokens tokens(clock, "local", {.codes_max = 4});
  const std::string code = tokens.Issue({"run-1", {.caller = "user:1", .account_id = 1}, true});
  std::string newest;
  for (int i = 0; i < 10; ++i) {
    clock.Advance(std::chrono::milliseconds(1));
    newest = tokens.Issue({"r", {.caller = "guest " + std::to_string(i)}, false});
  }
  EXPECT_TRUE(tokens.Redeem(code));
  EXPECT_TRUE(tokens.Redeem(newest));
}

TEST(StreamTokens, EndWithTheRightByWhichTheyWereMade) {
  ManualClock clock;
  StreamTokens tokens(clock);
  const std::string ann = tokens.Issue({"run-1", {.account_id = 1, .sign_in = "a"}, true});
  const std::string bob = tokens.Issue({"run-1", {.account_id = 2, .sign_in = "b"}, true});
  tokens.Drop([](const ViewerOwner& owner) { return owner.account_id == 1; });
  EXPECT_FALSE(tokens.Redeem(ann));
  EXPECT_TRUE(tokens.Redeem(bob));
}

TEST(StreamTokens, AreNeverTheSame) {
  ManualClock clock;
  StreamTokens tokens(clock);
  std::set<std::string> codes;
  for (int i = 0; i < 1000; ++i) codes.insert(tokens.Issue({"run", {}, false}));
  EXPECT_EQ(codes.size(), 1000u);
}

}  // namespace
}  // namespace faultlab::server
