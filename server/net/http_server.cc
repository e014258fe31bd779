#include "server/net/http_server.h"

#include <algorithm>
#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <ctime>
#include <exception>
#include <future>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "server/address_key.h"
#include "server/net/connection.h"
#include "server/net/listen_address.h"
#include "server/net/response_head.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Steady = std::chrono::steady_clock;

}  // namespace

class HttpServer::Impl {
 public:
  Impl(HttpServerOptions options,
       const Router& router,
       std::function<UpgradeDecision(const HttpRequest&)> upgrade)
      : host_{.options = std::move(options), .router = router, .upgrade = std::move(upgrade)},
        acceptor_(host_.io),
        sweep_timer_(host_.io) {
    Tick();
  }

  core::Status Bind();
  core::Status Start();
  void Stop();
  HttpCounters counters() const;

  ConnectionHost host_;
  std::string bound_host_;
  int port_ = 0;

 private:
  asio::awaitable<void> Accept();
  asio::awaitable<void> Sweep();
  void Tick();
  void CloseAll();
  const char* RefusalOf(const tcp::socket& socket);
  bool CloseOneThatWaits();

  bool stopping_ = false;
  bool started_ = false;
  tcp::acceptor acceptor_;
  asio::steady_timer sweep_timer_;
  std::thread thread_;
};

asio::awaitable<void> HttpServer::Impl::Accept() {
  while (!stopping_) {
    error_code ec;
    tcp::socket socket =
        co_await acceptor_.async_accept(asio::redirect_error(asio::use_awaitable, ec));
    if (stopping_) co_return;
    if (ec) {
      host_.Report("accept: " + ec.message());
      // Most likely there are no free descriptors: give running requests a moment to end.
      asio::steady_timer pause(host_.io, std::chrono::milliseconds(100));
      co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ec));
      continue;
    }
    ++host_.counters.accepted;
    if (const char* refusal = RefusalOf(socket)) {
      ++host_.counters.refused;
      const std::string bytes =
          EncodeResponseHead(Problem(503, "busy", "Busy", refusal), host_.date, false, true);
      socket.non_blocking(true, ec);
      socket.write_some(asio::buffer(bytes), ec);
      continue;
    }
    asio::co_spawn(
        host_.io,
        [this, taken = std::move(socket)]() mutable -> asio::awaitable<void> {
          Connection connection(host_, std::move(taken));
          co_await connection.Run();
        },
        [this](std::exception_ptr failure) {
          if (!failure) return;
          try {
            std::rethrow_exception(failure);
          } catch (const std::exception& error) {
            host_.Report(std::string("connection: ") + error.what());
          }
        });
  }
}

/// Whether there is room for one more connection; if not, one that waits is closed.
const char* HttpServer::Impl::RefusalOf(const tcp::socket& socket) {
  error_code ec;
  const std::string peer = socket.remote_endpoint(ec).address().to_string();
  const auto& limits = host_.options.limits;
  const bool proxy = IsLoopbackHost(peer) || host_.options.trusted_proxies.Has(peer);
  if (!proxy && host_.of_address.Of(AddressKey(peer)) >= limits.connections_per_address_max) {
    return "Too many connections from your address; close some.";
  }
  const std::size_t tunnels = host_.counters.tunnels;  // tunnels have a limit of their own
  if (host_.connections.size() - tunnels < limits.connections_max) return nullptr;
  return CloseOneThatWaits() ? nullptr : "Too many connections; try again in a minute.";
}

/// Closes an idle connection, or, if none is idle, one that waits for its client. Of the client
/// that has most such connections, the one that has waited longest is closed.
bool HttpServer::Impl::CloseOneThatWaits() {
  Connection* victim = nullptr;
  std::tuple<bool, std::size_t, Steady::duration> worst;
  for (Connection* connection : host_.connections) {
    const bool idle = connection->idle();
    if (!idle && !connection->waits_for_client()) continue;
    const std::tuple rank(idle,
                          idle ? connection->of_address() : connection->waiting_of_client(),
                          host_.now - connection->waits_since());
    if (victim != nullptr && rank <= worst) continue;
    victim = connection;
    worst = rank;
  }
  if (victim == nullptr) return false;
  victim->Close();
  return true;
}

void HttpServer::Impl::Tick() {
  host_.now = Steady::now();
  const std::time_t seconds = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 40> text{};
  const std::size_t size =
      std::strftime(text.data(), text.size(), "%a, %d %b %Y %H:%M:%S GMT", &parts);
  host_.date.assign(text.data(), size);
}

asio::awaitable<void> HttpServer::Impl::Sweep() {
  const auto& limits = host_.options.limits;
  const auto step = std::clamp<std::chrono::milliseconds>(
      std::min(std::min(limits.header_deadline, limits.body_deadline),
               std::min({limits.write_deadline, limits.idle_deadline, limits.look_every})) /
          4,
      std::chrono::milliseconds(10),
      std::chrono::milliseconds(500));
  while (!stopping_ || !host_.connections.empty()) {
    Tick();
    const std::vector<Connection*> all(host_.connections.begin(), host_.connections.end());
    for (Connection* connection : all) connection->Sweep();
    error_code ec;
    sweep_timer_.expires_after(stopping_ ? std::chrono::milliseconds(10) : step);
    co_await sweep_timer_.async_wait(asio::redirect_error(asio::use_awaitable, ec));
  }
  host_.io.stop();
}

core::Status HttpServer::Impl::Bind() {
  TRY(const auto address, ParseListenAddress(host_.options.listen));
  const auto refusal = [this](const error_code& ec) {
    return core::Error{core::ErrorCode::kUnavailable,
                       "cannot listen on " + host_.options.listen + ": " + ec.message(),
                       "listen"};
  };
  error_code ec;
  const tcp::endpoint endpoint(asio::ip::make_address(address.host), address.port);
  acceptor_.open(endpoint.protocol(), ec);
  if (!ec) acceptor_.set_option(tcp::acceptor::reuse_address(true), ec);
  if (!ec) acceptor_.bind(endpoint, ec);
  const tcp::socket::send_buffer_size inherited(host_.options.limits.send_buffer_bytes);
  if (!ec) acceptor_.set_option(inherited, ec);
  if (!ec) acceptor_.listen(asio::socket_base::max_listen_connections, ec);
  if (ec) return refusal(ec);
  port_ = acceptor_.local_endpoint().port();
  bound_host_ = address.host;
  host_.on_loopback = IsLoopbackHost(address.host);
  return core::Done{};
}

core::Status HttpServer::Impl::Start() {
  if (!acceptor_.is_open()) {
    TRY_DONE(Bind());
  }
  for (HandlerPool* pool : host_.Pools()) pool->Start();
  Tick();
  asio::co_spawn(host_.io, Accept(), asio::detached);
  asio::co_spawn(host_.io, Sweep(), asio::detached);
  started_ = true;
  thread_ = std::thread([this] { host_.io.run(); });
  return core::Done{};
}

void HttpServer::Impl::CloseAll() {
  stopping_ = true;
  for (HandlerPool* pool : host_.Pools()) pool->Close();
  error_code ec;
  acceptor_.close(ec);
  const std::vector<Connection*> all(host_.connections.begin(), host_.connections.end());
  for (Connection* connection : all) connection->CloseIfIdle();
  sweep_timer_.cancel();
}

void HttpServer::Impl::Stop() {
  if (!started_) return;
  started_ = false;
  // After the pool is joined nothing may be given to it, because its end would come after the end
  // of io.
  std::promise<void> closed;
  asio::post(host_.io, [&] {
    CloseAll();
    closed.set_value();
  });
  closed.get_future().wait();
  for (HandlerPool* pool : host_.Pools()) pool->Join();
  asio::steady_timer hard_stop(host_.io, std::chrono::seconds(1));
  hard_stop.async_wait([this](const error_code& ec) {
    if (!ec) host_.io.stop();
  });
  thread_.join();
}

HttpCounters HttpServer::Impl::counters() const {
  HttpCounters out;
  out.connections_accepted = host_.counters.accepted;
  out.connections_refused = host_.counters.refused;
  out.connections_open = host_.counters.open;
  out.requests = host_.counters.requests;
  out.deadlines_missed = host_.counters.deadlines;
  out.pool_refused = host_.counters.pool_refused;
  for (const HandlerPool* pool : {&host_.pool, &host_.heavy, &host_.password, &host_.outside}) {
    out.pool_waiting += pool->waiting();
  }
  out.bytes_refused = host_.counters.bytes_refused;
  out.bytes_waiting = host_.waiting_bytes.held();
  out.passed_on = host_.counters.passed_on;
  out.peers_silent = host_.counters.peers_silent;
  out.tunnels_open = host_.counters.tunnels;
  out.waits_open = host_.counters.waits;
  for (std::size_t i = 0; i < host_.counters.answers.size(); ++i) {
    out.answers_by_class[i] = host_.counters.answers[i];
  }
  return out;
}

HttpServer::HttpServer(HttpServerOptions options,
                       const Router& router,
                       std::function<UpgradeDecision(const HttpRequest&)> upgrade)
    : impl_(std::make_unique<Impl>(std::move(options), router, std::move(upgrade))) {}

HttpServer::~HttpServer() {
  Stop();
}

void HttpServer::SetHopSeal(ForwardingSeal seal) {
  impl_->host_.seal.emplace(std::move(seal));
}

core::Status HttpServer::Bind() {
  return impl_->Bind();
}

core::Status HttpServer::Start() {
  return impl_->Start();
}

int HttpServer::port() const {
  return impl_->port_;
}

std::string HttpServer::address() const {
  const bool v6 = impl_->bound_host_.find(':') != std::string::npos;
  return (v6 ? "[" + impl_->bound_host_ + "]" : impl_->bound_host_) + ":" +
         std::to_string(impl_->port_);
}

bool HttpServer::on_loopback() const {
  return impl_->host_.on_loopback;
}

void HttpServer::Stop() {
  impl_->Stop();
}

HttpCounters HttpServer::counters() const {
  return impl_->counters();
}

}  // namespace faultlab::server
