// Bytes on a connection to the real server code, over loopback in one thread: several requests in
// sequence, broken ones. Each answer is well-formed; nothing stays open.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>

#include "server/net/connection.h"
#include "server/net/connection_host.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab::server;  // NOLINT(google-build-using-namespace)
using faultlab::fuzz::Require;

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

class World {
 public:
  World()
      : host_{.options = Options(), .router = router_, .upgrade = Upgrade, .on_loopback = true},
        acceptor_(host_.io, {asio::ip::address_v4::loopback(), 0}) {
    Add(HttpMethod::kGet, "/", 0);
    Add(HttpMethod::kGet, "/runs/{id}", 0);
    Add(HttpMethod::kPost, "/runs", 64);
  }

  void Give(std::string_view bytes) {
    const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const auto to = acceptor_.local_endpoint();
    Require(client >= 0 && connect(client, to.data(), static_cast<socklen_t>(to.size())) == 0);
    // Closes without TIME_WAIT, because there are a million connections one after the other.
    const linger none{.l_onoff = 1, .l_linger = 0};
    setsockopt(client, SOL_SOCKET, SO_LINGER, &none, sizeof none);
    (void)!send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    shutdown(client, SHUT_WR);
    {
      Connection connection(host_, acceptor_.accept());
      asio::co_spawn(host_.io, connection.Run(), asio::detached);
      host_.io.restart();
      while (host_.io.run_one_for(std::chrono::seconds(5)) > 0) {
      }
      Require(host_.io.stopped());  // the connection has ended: no work is left
    }
    CheckAnswers(client);
    close(client);
  }

 private:
  static HttpServerOptions Options() {
    HttpServerOptions options;
    options.limits.header_bytes_max = 512;
    return options;
  }
  static UpgradeDecision Upgrade(const HttpRequest&) {
    HttpResponse response;
    response.status = 404;
    return response;
  }
  void Add(HttpMethod method, const char* pattern, std::size_t body_bytes_max) {
    Route route;
    route.method = method;
    route.pattern = pattern;
    route.runs_on = RunsOn::kInline;
    route.body_bytes_max = body_bytes_max;
    route.handle = [body_bytes_max](const HttpRequest& request) {
      Require(request.body.size() <= body_bytes_max);
      HttpResponse response;
      response.body = "{}";
      return response;
    };
    router_.Add(std::move(route));
  }
  static void CheckAnswers(int client) {
    std::string answers(1 << 16, '\0');
    const ssize_t got = recv(client, answers.data(), answers.size(), MSG_DONTWAIT);
    if (got > 0) Require(answers.starts_with("HTTP/1.1 "));
  }

  Router router_;
  ConnectionHost host_;
  tcp::acceptor acceptor_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static World world;
  world.Give(faultlab::fuzz::Text(data, size));
  return 0;
}
