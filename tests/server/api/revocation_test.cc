// Connections end with the right by which they were opened.
#include <boost/json.hpp>
#include <memory>

#include "tests/server/api/api_world.h"
#include "tests/support/raw_client.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class RevocationTest : public ApiTest {
 protected:
  RevocationTest() { PlayAtSpeed(4.0); }

  /// A person's viewer of their own run, by which they may send commands.
  std::unique_ptr<tests::WebSocketClient> Watch(const Person& who) {
    if (run_.empty()) {
      const json::object run = Ok(Call(who, "POST runs", R"({"duration_s":600})"), 201);
      run_ = run.at("id").as_string();
    }
    return Open(who, true);
  }
  /// Another person's viewer of that run.
  std::unique_ptr<tests::WebSocketClient> WatchOf(const Person& who) { return Open(who, false); }
  std::unique_ptr<tests::WebSocketClient> Open(const Person& who, bool commands) {
    const std::string target = "runs/" + run_ + "/stream-token";
    const json::object token = Ok(Call(who, "POST " + target, "{}"), 201);
    auto page = std::make_unique<tests::WebSocketClient>(application_->port(),
                                                         "/ws?code=" + Text(token, "code"));
    const auto hello = page->ReadTextWith("\"hello\"");
    const std::string can = commands ? "\"can_command\":true" : "\"can_command\":false";
    EXPECT_TRUE(hello && hello->find(can) != std::string::npos);
    return page;
  }
  /// The close code of the server; 0 if the connection ends without one.
  static int CloseCodeOf(tests::WebSocketClient& page) {
    while (const auto frame = page.Read()) {
      if (frame->opcode == 8) return frame->close_code();
    }
    return 0;
  }

  std::string run_;
};

TEST_F(RevocationTest, SigningOutClosesTheWindowsOfThisSignInAlone) {
  const Person here = Make("ann", Role::kStudent);
  const Person there = ByPassword("ann");
  const auto closed = Watch(here);
  const auto open = Watch(there);
  EXPECT_EQ(Call(here, "POST auth/logout", "{}").status, 204);
  EXPECT_EQ(CloseCodeOf(*closed), 1008);
  open->SendText(R"({"type":"ping","t":1})");
  EXPECT_TRUE(open->ReadTextWith("\"pong\""));
}

TEST_F(RevocationTest, ADisabledAccountCommandsNothingAnyMore) {
  const Person ann = Make("ann", Role::kStudent);
  const auto page = Watch(ann);
  const std::int64_t id = AccountOf("ann");
  const Person admin = Admin();
  const json::object user = Ok(
      Call(admin, "PATCH users/" + std::to_string(id), R"({"disabled":true})", "If-Match: 1\r\n"));
  EXPECT_TRUE(user.at("disabled").as_bool());
  EXPECT_EQ(CloseCodeOf(*page), 1008);
}

TEST_F(RevocationTest, WhatAnotherProcessEndsIsNoticed) {
  const Person ann = Make("ann", Role::kStudent);
  const auto page = Watch(ann);
  // As `faultlab admin` does: this object is not the server's.
  ASSERT_TRUE(accounts_->Change(AccountOf("ann"), 1, {}, {}, true).ok());
  EXPECT_EQ(CloseCodeOf(*page), 1008);
}

TEST_F(RevocationTest, ARoleThatAnotherProcessTookIsNoticed) {
  const Person ann = Make("ann", Role::kStudent);
  const Person eve = Make("eve", Role::kOperator);
  const auto own = Watch(ann);
  const auto page = WatchOf(eve);
  const json::object token = Ok(Call(eve, "POST runs/" + run_ + "/stream-token", "{}"), 201);
  ASSERT_TRUE(accounts_->Change(AccountOf("eve"), 1, {}, Role::kStudent, {}).ok());
  EXPECT_EQ(CloseCodeOf(*page), 1008);
  const auto late =
      tests::Get(application_->port(),
                 "/ws?code=" + Text(token, "code"),
                 "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
  EXPECT_EQ(late.status, 403) << "nor does a code that was taken before";
  own->SendText(R"({"type":"ping","t":1})");
  EXPECT_TRUE(own->ReadTextWith("\"pong\""));
}

TEST_F(RevocationTest, AnEnrolmentThatAnotherProcessEndedIsNoticed) {
  const Person ann = Make("ann", Role::kStudent);
  const Person teacher = Make("teacher", Role::kInstructor);
  const Course course = MakeCourse("teacher", "ann");
  const auto own = Watch(ann);
  const auto page = WatchOf(teacher);
  ASSERT_TRUE(accounts_->EndEnrolment(course.id, AccountOf("ann")).ok());
  EXPECT_EQ(CloseCodeOf(*page), 1008);
  own->SendText(R"({"type":"ping","t":1})");
  EXPECT_TRUE(own->ReadTextWith("\"pong\""));
}

TEST_F(RevocationTest, ACodeEndsWithItsSignIn) {
  const Person ann = Make("ann", Role::kStudent);
  const auto page = Watch(ann);
  const json::object token = Ok(Call(ann, "POST runs/" + run_ + "/stream-token", "{}"), 201);
  EXPECT_EQ(Call(ann, "POST auth/logout", "{}").status, 204);
  const auto late =
      tests::Get(application_->port(),
                 "/ws?code=" + Text(token, "code"),
                 "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
  EXPECT_EQ(late.status, 403);
}

}  // namespace
}  // namespace faultlab::server
