// server/stream/asyncapi.json against what is really sent.
#include <boost/json.hpp>
#include <set>

#include "tests/server/api/api_world.h"
#include "tests/support/paths.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class StreamDescription : public ApiTest {
 protected:
  StreamDescription() {
    const json::value read = json::parse(ReadText(tests::InSource("server/stream/asyncapi.json")));
    messages_ = read.at("components").at("messages").as_object();
    channels_ = read.at("channels").as_object();
  }
  /// Checks a text by its type. @returns its type
  std::string Check(const std::string& text) {
    const json::value message = json::parse(text);
    const std::string type = Text(message, "type");
    const json::value* const known = messages_.if_contains(type);
    EXPECT_NE(known, nullptr) << type << " is not described";
    if (known == nullptr) return type;
    const auto wrong = description_.CheckSchema(message, known->at("payload"));
    EXPECT_FALSE(wrong) << type << ": " << wrong.value_or("") << "\n" << text.substr(0, 400);
    return type;
  }
  std::unique_ptr<tests::WebSocketClient> Open(const Person& who, const std::string& target) {
    const json::object code = Ok(Call(who, "POST " + target, "{}"), 201);
    return std::make_unique<tests::WebSocketClient>(application_->port(),
                                                    "/ws?code=" + Text(code, "code"));
  }

  json::object messages_;
  json::object channels_;
};

TEST_F(StreamDescription, NamesEveryMessageOfARunAndOfTheLab) {
  PlayAtSpeed(10);
  const Person ann = Make("ann", Role::kStudent);
  std::set<std::string> seen;
  const auto feed = Open(ann, "events/stream-token");
  seen.insert(Check(feed->ReadTextWith("\"lab\"").value_or("{}")));

  const json::object run = Ok(
      Call(ann,
           "POST runs",
           R"({"rig":"sim-1","duration_s":30,"faults":[{"component":"R1","value":100,"at_s":8}]})"),
      201);
  const std::string id = Id(run);
  const auto live = Open(ann, "runs/" + id + "/stream-token");
  live->SendText(R"({"type":"ping","t":1.5})");
  live->SendText(R"({"type":"command","epoch":0,"id":"a","action":"dance"})");
  live->SendText(R"({"type":"command","epoch":1,"id":7,"action":"nominal"})");
  live->SendText(R"({"type":"resume","since":0})");
  while (const auto frame = live->Read()) {
    if (frame->opcode == 8) break;
    if (frame->opcode == 2) {
      EXPECT_EQ((frame->payload.size() - 16) % 100, 0u) << "23 x 4 and 8 bytes a sample";
      seen.insert("block");
    }
    if (frame->opcode != 1) continue;
    if (seen.insert(Check(frame->payload)).first->compare("end") == 0) break;
  }
  for (const auto& [name, message] : messages_) {
    const bool sent = std::set<std::string_view>{"command", "ping", "resume"}.contains(name);
    const bool slow = name == "dropped";  // of a viewer that does not read: tests/server/stream
    EXPECT_TRUE(sent || slow || seen.contains(std::string(name))) << name << " was not seen";
  }
  for (const auto& [name, channel] : channels_) {
    for (const auto& [key, ref] : channel.at("messages").as_object()) {
      EXPECT_TRUE(messages_.contains(key)) << name << " " << key;
    }
  }
}

}  // namespace
}  // namespace faultlab::server
