// Webhooks of people, also by a key.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/json.hpp>

#include "core/types/check.h"
#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

/// Somebody in this machine who must not be reached.
class Listener {
 public:
  Listener() : socket_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(at);
    LAB_CHECK(bind(socket_, reinterpret_cast<sockaddr*>(&at), size) == 0);
    LAB_CHECK(listen(socket_, 4) == 0);
    LAB_CHECK(getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size) == 0);
    port_ = ntohs(at.sin_port);
  }
  ~Listener() { close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  std::string Url(const std::string& host) const {
    return "https://" + host + ":" + std::to_string(port_) + "/hook";
  }
  /// Whether anybody has come since the last call.
  bool WasReached() const {
    const int came = accept(socket_, nullptr, nullptr);
    if (came >= 0) close(came);
    return came >= 0;
  }

 private:
  int socket_;
  int port_ = 0;
};

class WebhooksApi : public ApiTest {
 protected:
  Person KeyOf(const Person& who, const json::array& scopes) {
    const json::object body{
        {"name", "robot"}, {"scopes", scopes}, {"expires_at", In(std::chrono::hours(24))}};
    const json::object key = Ok(Call(who, "POST api-keys", json::serialize(body)), 201);
    return {"Authorization: Bearer " + Text(key, "key") + "\r\n"};
  }
  HttpAnswer Add(const Person& who,
                 const std::string& url,
                 const json::array& kinds,
                 const char* of = nullptr) {
    json::object body{{"url", url}, {"kinds", kinds}};
    if (of != nullptr) body["of"] = of;
    return Call(who, "POST webhooks", json::serialize(body));
  }
  std::size_t Count(const Person& who) { return Items(who, "webhooks").size(); }
  bool TestIsTaken(const Person& who, const json::object& hook) {
    const std::string path = "webhooks/" + Id(hook) + "/test";
    return Ok(Call(who, "POST " + path, "{}")).at("taken").as_bool();
  }
};

TEST_F(WebhooksApi, AKeyHasThoseOfItsAccountAndNoOthers) {
  const Person ann = Make("ann", Role::kStudent);
  const Person robot = KeyOf(ann, {"lab"});
  const Person admin = Admin();
  const json::object made = Ok(Add(robot, "https://hooks.example/a", {"job_ended"}), 201);
  EXPECT_EQ(made.at("of"), "me");
  EXPECT_TRUE(made.contains("secret"));
  EXPECT_EQ(Count(ann), 1u);
  EXPECT_EQ(Add(KeyOf(ann, {"jobs"}), "https://hooks.example/a", {"job_ended"}).status, 403);
  EXPECT_EQ(Add(ann, "https://hooks.example/a", {"your_turn"}, "lab").status, 403);
  EXPECT_EQ(Add(ann, "https://hooks.example/a", {"rig_quarantined"}).status, 400);
  EXPECT_EQ(Add(admin, "https://hooks.example/a", {"job_ended"}).status, 400) << "the lab's";
  const json::object labs = Ok(Add(admin, "https://hooks.example/l", {"rig_quarantined"}), 201);
  EXPECT_EQ(labs.at("of"), "lab");
  EXPECT_EQ(Count(ann), 1u);
  EXPECT_EQ(Count(admin), 1u) << "hers is not the lab's";
  EXPECT_EQ(Count(KeyOf(admin, {"lab", "operate"})), 0u);
  const auto remove = [&](const Person& who, const json::object& hook) {
    return Call(who, "DELETE webhooks/" + Id(hook)).status;
  };
  EXPECT_EQ(remove(robot, labs), 404);
  EXPECT_EQ(remove(Make("bob", Role::kStudent), made), 404);
  EXPECT_EQ(remove(admin, made), 404);
  EXPECT_EQ(remove(robot, made), 204);
  for (int i = 0; i < 5; ++i) Ok(Add(ann, "https://hooks.example/a", {"run_ended"}), 201);
  EXPECT_EQ(Add(ann, "https://hooks.example/a", {"run_ended"}).status, 409);
}

TEST_F(WebhooksApi, APersonsHookReachesNobodyInTheMachineOrItsNetwork) {
  const Listener inside;
  const Person ann = Make("ann", Role::kStudent);
  const Person admin = Admin();
  for (const char* host : {"127.0.0.1", "localhost", "127.1", "0.0.0.0", "[::ffff:127.0.0.1]"}) {
    const HttpAnswer made = Add(ann, inside.Url(host), {"run_ended"});
    if (made.status == 400) continue;  // no address at all
    EXPECT_FALSE(TestIsTaken(ann, Ok(made, 201))) << host;
    EXPECT_FALSE(inside.WasReached()) << host;
  }
  const json::object labs = Ok(Add(admin, inside.Url("127.0.0.1"), {"rig_quarantined"}), 201);
  EXPECT_FALSE(TestIsTaken(admin, labs)) << "it speaks no TLS";
  EXPECT_TRUE(inside.WasReached()) << "an admin is trusted with the institute's own services";
}

}  // namespace
}  // namespace faultlab::server
