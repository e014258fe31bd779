#include "server/net/http_server.h"

#include <utility>

#include <sys/socket.h>

#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <ctime>
#include <exception>
#include <optional>
#include <thread>
#include <unordered_set>

#include "server/net/listen_address.h"
#include "server/net/websocket.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using boost::system::error_code;
using Steady = std::chrono::steady_clock;

constexpr std::size_t kReadBytes = 4096;
constexpr std::size_t kBodyReadBytes = 64 << 10;
constexpr std::size_t kIdleBufferBytesMax = 16 << 10;
constexpr std::size_t kInlineBodyBytes = 8 << 10;  ///< copied behind the head: one buffer, one send
constexpr std::size_t kDiscardBytesMax = 4 << 20;  ///< read away so that a refusal is not reset

constexpr std::string_view kSecurityHeaders =
    "Content-Security-Policy: default-src 'self'; object-src 'none'; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Permissions-Policy: camera=(), microphone=(), geolocation=()\r\n";

HttpMethod ToMethod(beast::http::verb verb) {
  switch (verb) {
    case beast::http::verb::get:
      return HttpMethod::kGet;
    case beast::http::verb::head:
      return HttpMethod::kHead;
    case beast::http::verb::post:
      return HttpMethod::kPost;
    case beast::http::verb::put:
      return HttpMethod::kPut;
    case beast::http::verb::patch:
      return HttpMethod::kPatch;
    case beast::http::verb::delete_:
      return HttpMethod::kDelete;
    default:
      return HttpMethod::kOther;
  }
}

std::string_view View(beast::string_view text) {
  return {text.data(), text.size()};
}

std::string_view LastListEntry(std::string_view list) {
  const std::size_t comma = list.rfind(',');
  std::string_view entry = comma == std::string_view::npos ? list : list.substr(comma + 1);
  while (entry.starts_with(' ')) entry.remove_prefix(1);
  return entry;
}

/// The head of an answer, and its payload too when that is small.
std::string EncodeHead(const HttpResponse& response,
                       std::string_view date,
                       bool keep_alive,
                       bool with_payload) {
  const std::string_view payload = response.payload();
  std::string head;
  head.reserve(900 + (with_payload ? payload.size() : 0));
  head.append("HTTP/1.1 ").append(std::to_string(response.status)).append(" ");
  head.append(ReasonPhrase(response.status)).append("\r\nServer: faultlab\r\nDate: ").append(date);
  if (response.status != 304 && response.status != 204) {
    head.append("\r\nContent-Type: ").append(response.content_type);
    head.append("\r\nContent-Length: ").append(std::to_string(payload.size()));
  }
  head.append("\r\n").append(kSecurityHeaders);
  bool cache_named = false;
  for (const auto& [name, value] : response.headers) {
    head.append(name).append(": ").append(value).append("\r\n");
    cache_named = cache_named || name == "Cache-Control";
  }
  if (!cache_named) head.append("Cache-Control: no-store\r\n");
  if (!keep_alive) head.append("Connection: close\r\n");
  head.append("\r\n");
  if (with_payload) head.append(payload);
  return head;
}

HttpResponse InternalProblem() {
  return Problem(500,
                 "internal",
                 "Internal error",
                 "The server made a mistake; it is logged. Nothing was changed by this request.");
}

}  // namespace

class HttpServer::Impl {
 public:
  Impl(HttpServerOptions options,
       const Router& router,
       std::function<UpgradeDecision(const HttpRequest&)> upgrade)
      : options_(std::move(options)),
        router_(router),
        upgrade_(std::move(upgrade)),
        acceptor_(io_),
        sweep_timer_(io_) {}

  core::Status Start();
  void Stop();
  HttpCounters counters() const;

  HttpServerOptions options_;
  const Router& router_;
  std::function<UpgradeDecision(const HttpRequest&)> upgrade_;
  std::string host_;
  int port_ = 0;
  bool on_loopback_ = false;

 private:
  class Session;
  friend class Session;

  asio::awaitable<void> Accept();
  asio::awaitable<void> Sweep();
  void Tick();
  void CloseAll();
  void Report(std::string_view text) const {
    if (options_.on_error) options_.on_error(text);
  }

  struct Counters {
    std::atomic<std::uint64_t> accepted{0}, refused{0}, open{0}, requests{0}, deadlines{0},
        pool_refused{0};
    std::array<std::atomic<std::uint64_t>, 6> answers{};
  };
  Counters counters_;
  std::atomic<std::size_t> pool_waiting_{0};
  std::unordered_set<Session*> sessions_;
  Steady::time_point now_ = Steady::now();  ///< coarse: moved by Sweep
  std::string date_;
  bool stopping_ = false;
  bool started_ = false;
  // Sessions live in the coroutines that io_ owns: io_ goes first, what they touch stays above.
  std::optional<asio::thread_pool> pool_;
  asio::io_context io_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer sweep_timer_;
  std::thread thread_;
};

/// One connection. Lives in its own coroutine on the network thread.
class HttpServer::Impl::Session {
 public:
  Session(Impl& server, tcp::socket socket) : server_(server), socket_(std::move(socket)) {
    server_.sessions_.insert(this);
    ++server_.counters_.open;
    error_code ec;
    socket_.set_option(tcp::no_delay(true), ec);
    socket_.non_blocking(true, ec);
    const auto peer = socket_.remote_endpoint(ec);
    if (!ec) {
      const auto address = peer.address();
      peer_address_ = address.to_string();
      peer_is_loopback_ = address.is_loopback();
    }
  }
  ~Session() {
    server_.sessions_.erase(this);
    --server_.counters_.open;
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  asio::awaitable<void> Run();

  void CloseIfLate(Steady::time_point now) {
    if (now < deadline_) return;
    ++server_.counters_.deadlines;
    if (reading_request_) {
      // Best effort: a socket that takes no bytes now is closed without them.
      const HttpResponse late = Problem(
          408, "timeout", "Request timeout", "The request did not arrive in time; send it faster.");
      const std::string bytes = EncodeHead(late, server_.date_, false, true);
      error_code ec;
      socket_.write_some(asio::buffer(bytes), ec);
    }
    Close();
  }
  void CloseIfIdle() {
    last_request_ = true;
    if (idle_) Close();
  }

 private:
  using Parser = beast::http::request_parser<beast::http::string_body>;
  enum class Next { kKeepAlive, kClose, kUpgraded };

  void Close() {
    error_code ec;
    socket_.close(ec);
  }
  void Deadline(std::chrono::milliseconds from_now) { deadline_ = server_.now_ + from_now; }

  asio::awaitable<bool> ReadMore(std::size_t bytes);
  asio::awaitable<bool> ReadHeader();
  asio::awaitable<bool> ReadBody(std::size_t bytes_max);
  asio::awaitable<Next> Serve();
  asio::awaitable<Next> Upgrade();
  asio::awaitable<HttpResponse> RunOnPool(const Route& route);
  asio::awaitable<bool> Send(const HttpResponse& response, bool keep_alive);
  asio::awaitable<bool> SendBytes(std::string_view bytes);
  asio::awaitable<void> Refuse(HttpResponse response);
  void FillRequest();
  HttpResponse Handle(const Route& route) const;

  Impl& server_;
  tcp::socket socket_;
  beast::flat_buffer buffer_;
  std::optional<Parser> parser_;
  HttpRequest request_;
  std::string peer_address_;
  Steady::time_point deadline_ = Steady::time_point::max();
  bool peer_is_loopback_ = false;
  bool reading_request_ = false;
  bool idle_ = false;
  bool last_request_ = false;
};

asio::awaitable<bool> HttpServer::Impl::Session::ReadMore(std::size_t bytes) {
  error_code ec;
  const std::size_t got = co_await socket_.async_read_some(
      buffer_.prepare(bytes), asio::redirect_error(asio::use_awaitable, ec));
  if (ec || got == 0) co_return false;
  buffer_.commit(got);
  co_return true;
}

asio::awaitable<bool> HttpServer::Impl::Session::ReadHeader() {
  request_.method = HttpMethod::kGet;  // until known: a refusal then carries its body
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(server_.options_.limits.header_bytes_max));
  // The limit of the body depends on the route: checked by Serve before a byte of it is taken.
  parser_->body_limit(boost::none);
  for (;;) {
    if (buffer_.size() > 0) {
      error_code ec;
      buffer_.consume(parser_->put(buffer_.data(), ec));
      if (parser_->is_header_done()) co_return true;
      if (ec == beast::http::error::header_limit) {
        co_await Refuse(Problem(431,
                                "header_too_large",
                                "Header too large",
                                "Request line and headers together may have at most " +
                                    std::to_string(server_.options_.limits.header_bytes_max) +
                                    " bytes."));
        co_return false;
      }
      if (ec && ec != beast::http::error::need_more) {
        co_await Refuse(
            Problem(400, "bad_request", "Not HTTP/1.1", "Bad request: " + ec.message() + "."));
        co_return false;
      }
      if (!reading_request_) {
        reading_request_ = true;
        Deadline(server_.options_.limits.header_deadline);
      }
    }
    if (!co_await ReadMore(kReadBytes)) co_return false;
    idle_ = false;
  }
}

asio::awaitable<bool> HttpServer::Impl::Session::ReadBody(std::size_t bytes_max) {
  const auto too_large = [bytes_max] {
    return Problem(413,
                   "too_large",
                   "Body too large",
                   "This address takes a body of at most " + std::to_string(bytes_max) + " bytes.");
  };
  if (parser_->content_length().value_or(0) > bytes_max) {
    co_await Refuse(too_large());
    co_return false;
  }
  if (parser_->is_done()) co_return true;
  parser_->body_limit(bytes_max);
  if (View(parser_->get()[beast::http::field::expect]) == "100-continue") {
    if (!co_await SendBytes("HTTP/1.1 100 Continue\r\n\r\n")) co_return false;
  }
  reading_request_ = true;
  Deadline(server_.options_.limits.body_deadline);
  parser_->eager(true);
  while (!parser_->is_done()) {
    error_code ec;
    std::size_t used = 0;
    if (buffer_.size() > 0) {
      used = parser_->put(buffer_.data(), ec);
      buffer_.consume(used);
    }
    if (ec == beast::http::error::body_limit) {
      co_await Refuse(too_large());
      co_return false;
    }
    if (ec && ec != beast::http::error::need_more) {
      co_await Refuse(Problem(400, "bad_request", "Bad body", "Bad body: " + ec.message() + "."));
      co_return false;
    }
    if (parser_->is_done() || used > 0) continue;
    if (!co_await ReadMore(kBodyReadBytes)) co_return false;
  }
  co_return true;
}

void HttpServer::Impl::Session::FillRequest() {
  const auto& message = parser_->get();
  request_.method = ToMethod(message.method());
  request_.target = View(message.target());
  const std::size_t mark = request_.target.find('?');
  request_.path = request_.target.substr(0, mark);
  request_.query =
      mark == std::string_view::npos ? std::string_view() : request_.target.substr(mark + 1);
  request_.headers.clear();
  for (const auto& field : message) {
    request_.headers.emplace_back(View(field.name_string()), View(field.value()));
  }
  request_.path_parameters.clear();
  request_.body = {};
  request_.peer_is_loopback = peer_is_loopback_;
  request_.remote_address = peer_address_;
  request_.forwarded = false;
  request_.https = false;
  if (!peer_is_loopback_) return;
  if (const std::string_view list = request_.Header("X-Forwarded-For"); !list.empty()) {
    request_.remote_address = LastListEntry(list);
    request_.forwarded = true;
    request_.https = request_.Header("X-Forwarded-Proto") == "https";
  }
}

HttpResponse HttpServer::Impl::Session::Handle(const Route& route) const {
  try {
    return route.handle(request_);
  } catch (const std::exception& error) {
    server_.Report(std::string("handler of ") + route.pattern + ": " + error.what());
    return InternalProblem();
  }
}

asio::awaitable<HttpResponse> HttpServer::Impl::Session::RunOnPool(const Route& route) {
  if (server_.pool_waiting_ >= server_.options_.limits.pool_waiting_max) {
    ++server_.counters_.pool_refused;
    HttpResponse busy =
        Problem(503, "busy", "Busy", "Too many requests are waiting; try again in a second.");
    busy.headers.emplace_back("Retry-After", "1");
    co_return busy;
  }
  ++server_.pool_waiting_;
  co_return co_await asio::async_initiate<const asio::use_awaitable_t<>, void(HttpResponse)>(
      [this, &route](auto handler) {
        asio::post(*server_.pool_, [this, &route, handler = std::move(handler)]() mutable {
          --server_.pool_waiting_;
          HttpResponse response = Handle(route);
          asio::post(server_.io_,
                     [handler = std::move(handler), response = std::move(response)]() mutable {
                       std::move(handler)(std::move(response));
                     });
        });
      },
      asio::use_awaitable);
}

asio::awaitable<bool> HttpServer::Impl::Session::SendBytes(std::string_view bytes) {
  error_code ec;
  const std::size_t sent = socket_.write_some(asio::buffer(bytes.data(), bytes.size()), ec);
  if (!ec && sent == bytes.size()) co_return true;
  if (ec && ec != asio::error::would_block) co_return false;
  const std::size_t done = ec ? 0 : sent;
  ec = {};
  Deadline(server_.options_.limits.write_deadline);
  co_await asio::async_write(socket_,
                             asio::buffer(bytes.data() + done, bytes.size() - done),
                             asio::redirect_error(asio::use_awaitable, ec));
  co_return !ec;
}

asio::awaitable<bool> HttpServer::Impl::Session::Send(const HttpResponse& response,
                                                      bool keep_alive) {
  ++server_.counters_.answers[static_cast<std::size_t>(response.status / 100) % 6];
  const std::string_view payload = response.payload();
  const bool bodyless =
      request_.method == HttpMethod::kHead || response.status == 304 || response.status == 204;
  const bool joined = !bodyless && payload.size() <= kInlineBodyBytes;
  const std::string head = EncodeHead(response, server_.date_, keep_alive, joined);
  if (!co_await SendBytes(head)) co_return false;
  if (joined || bodyless) co_return true;
  co_return co_await SendBytes(payload);
}

/// Answers and ends the connection without a reset: what the client still sends is read away for a
/// while, for a reset would take the answer from under its eyes.
asio::awaitable<void> HttpServer::Impl::Session::Refuse(HttpResponse response) {
  reading_request_ = false;
  if (!co_await Send(response, false)) co_return;
  error_code ec;
  socket_.shutdown(tcp::socket::shutdown_send, ec);
  if (ec) co_return;
  Deadline(std::chrono::milliseconds(2000));
  std::array<char, 16 << 10> waste;
  for (std::size_t total = 0; total < kDiscardBytesMax;) {
    const std::size_t got = co_await socket_.async_read_some(
        asio::buffer(waste), asio::redirect_error(asio::use_awaitable, ec));
    if (ec) co_return;
    total += got;
  }
}

asio::awaitable<HttpServer::Impl::Session::Next> HttpServer::Impl::Session::Upgrade() {
  const auto refuse = [this](HttpResponse response) -> asio::awaitable<Next> {
    co_await Refuse(std::move(response));
    co_return Next::kClose;
  };
  if (request_.Header("Sec-WebSocket-Version") != "13") {
    HttpResponse response =
        Problem(426, "upgrade_required", "Wrong version", "Only WebSocket version 13 is spoken.");
    response.headers.emplace_back("Sec-WebSocket-Version", "13");
    co_return co_await refuse(std::move(response));
  }
  const std::string_view key = request_.Header("Sec-WebSocket-Key");
  if (!websocket::IsValidKey(key) || request_.method != HttpMethod::kGet) {
    co_return co_await refuse(Problem(
        400, "bad_handshake", "Bad handshake", "Sec-WebSocket-Key is not 16 bytes in base64."));
  }
  if (!OriginAllowed(request_.Header("Origin"), request_.Header("Host"))) {
    co_return co_await refuse(Problem(
        403, "foreign_origin", "Foreign origin", "A page of another site may not connect here."));
  }
  UpgradeDecision decision = server_.upgrade_(request_);
  if (auto* refusal = std::get_if<HttpResponse>(&decision)) {
    co_return co_await refuse(std::move(*refusal));
  }
  const std::string answer =
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Accept: " +
      websocket::AcceptKey(key) + "\r\n\r\n";
  if (!co_await SendBytes(answer)) co_return Next::kClose;
  UpgradedSocket upgraded;
  upgraded.pending.assign(static_cast<const char*>(buffer_.data().data()), buffer_.size());
  error_code ec;
  upgraded.fd = socket_.release(ec);
  if (ec) co_return Next::kClose;
  ++server_.counters_.answers[1];
  std::get<1>(decision)(std::move(upgraded));
  co_return Next::kUpgraded;
}

asio::awaitable<HttpServer::Impl::Session::Next> HttpServer::Impl::Session::Serve() {
  FillRequest();
  ++server_.counters_.requests;
  const std::string_view host = request_.Header("Host");
  if (!HostAllowed(host, server_.options_.allowed_hosts, server_.on_loopback_)) {
    co_await Refuse(Problem(421,
                            "unknown_host",
                            "Unknown host",
                            "This server does not answer to the name in the Host header; add it to "
                            "allowed_hosts."));
    co_return Next::kClose;
  }
  if (!request_.Header("Upgrade").empty() && request_.Header("Upgrade") == "websocket") {
    co_return co_await Upgrade();
  }
  const bool safe = request_.method == HttpMethod::kGet || request_.method == HttpMethod::kHead;
  if (!safe && !OriginAllowed(request_.Header("Origin"), host)) {
    co_await Refuse(Problem(
        403, "foreign_origin", "Foreign origin", "A page of another site may not do this here."));
    co_return Next::kClose;
  }
  const Router::Match match = server_.router_.Find(request_);
  if (!co_await ReadBody(match.route != nullptr ? match.route->body_bytes_max : 0)) {
    co_return Next::kClose;
  }
  reading_request_ = false;
  deadline_ = Steady::time_point::max();  // the handler's time is ours, not the client's
  request_.body = parser_->get().body();
  const bool keep_alive = parser_->get().keep_alive() && !last_request_;
  HttpResponse response;
  if (match.route != nullptr) {
    if (match.route->runs_on == RunsOn::kInline) {
      response = Handle(*match.route);
    } else {
      response = co_await RunOnPool(*match.route);
    }
  } else if (!match.allow.empty()) {
    response = Problem(405,
                       "method_not_allowed",
                       "Method not allowed",
                       "This address answers to " + match.allow + ".");
    response.headers.emplace_back("Allow", match.allow);
  } else {
    response = Problem(404, "not_found", "Not found", "There is nothing at this address.");
  }
  Deadline(server_.options_.limits.write_deadline);
  if (!co_await Send(response, keep_alive)) co_return Next::kClose;
  co_return keep_alive ? Next::kKeepAlive : Next::kClose;
}

asio::awaitable<void> HttpServer::Impl::Session::Run() {
  for (;;) {
    idle_ = buffer_.size() == 0;
    // A connection that waits keeps neither the last body nor the buffer it came through.
    if (idle_ && buffer_.capacity() > kIdleBufferBytesMax) buffer_.shrink_to_fit();
    reading_request_ = false;
    Deadline(server_.options_.limits.idle_deadline);
    if (!co_await ReadHeader()) co_return;
    idle_ = false;
    const Next next = co_await Serve();
    if (next == Next::kUpgraded) co_return;
    if (next == Next::kClose || last_request_) break;
  }
  error_code ec;
  socket_.shutdown(tcp::socket::shutdown_both, ec);
}

asio::awaitable<void> HttpServer::Impl::Accept() {
  while (!stopping_) {
    error_code ec;
    tcp::socket socket =
        co_await acceptor_.async_accept(asio::redirect_error(asio::use_awaitable, ec));
    if (stopping_) co_return;
    if (ec) {
      Report("accept: " + ec.message());
      // Out of descriptors, most likely: give running requests a moment to end.
      asio::steady_timer pause(io_, std::chrono::milliseconds(100));
      co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ec));
      continue;
    }
    ++counters_.accepted;
    if (sessions_.size() >= options_.limits.connections_max) {
      ++counters_.refused;
      const std::string bytes =
          EncodeHead(Problem(503, "busy", "Busy", "Too many connections; try again in a minute."),
                     date_,
                     false,
                     true);
      socket.non_blocking(true, ec);
      socket.write_some(asio::buffer(bytes), ec);
      continue;
    }
    asio::co_spawn(
        io_,
        [this, taken = std::move(socket)]() mutable -> asio::awaitable<void> {
          Session session(*this, std::move(taken));
          co_await session.Run();
        },
        [this](std::exception_ptr failure) {
          if (!failure) return;
          try {
            std::rethrow_exception(failure);
          } catch (const std::exception& error) {
            Report(std::string("connection: ") + error.what());
          }
        });
  }
}

void HttpServer::Impl::Tick() {
  now_ = Steady::now();
  const std::time_t seconds = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 40> text{};
  const std::size_t size =
      std::strftime(text.data(), text.size(), "%a, %d %b %Y %H:%M:%S GMT", &parts);
  date_.assign(text.data(), size);
}

asio::awaitable<void> HttpServer::Impl::Sweep() {
  const auto& limits = options_.limits;
  const auto step = std::clamp<std::chrono::milliseconds>(
      std::min(std::min(limits.header_deadline, limits.body_deadline),
               std::min(limits.write_deadline, limits.idle_deadline)) /
          4,
      std::chrono::milliseconds(10),
      std::chrono::milliseconds(500));
  while (!stopping_ || !sessions_.empty()) {
    Tick();
    const std::vector<Session*> all(sessions_.begin(), sessions_.end());
    for (Session* session : all) session->CloseIfLate(now_);
    error_code ec;
    sweep_timer_.expires_after(stopping_ ? std::chrono::milliseconds(10) : step);
    co_await sweep_timer_.async_wait(asio::redirect_error(asio::use_awaitable, ec));
  }
  io_.stop();
}

core::Status HttpServer::Impl::Start() {
  auto parsed = ParseListenAddress(options_.listen);
  if (!parsed) return parsed.error();
  const ListenAddress& address = parsed.value();
  const auto refusal = [this](const error_code& ec) {
    return core::Error{core::ErrorCode::kUnavailable,
                       "cannot listen on " + options_.listen + ": " + ec.message(),
                       "listen"};
  };
  error_code ec;
  const tcp::endpoint endpoint(asio::ip::make_address(address.host), address.port);
  acceptor_.open(endpoint.protocol(), ec);
  if (!ec) acceptor_.set_option(tcp::acceptor::reuse_address(true), ec);
  if (!ec) acceptor_.bind(endpoint, ec);
  if (!ec) acceptor_.listen(asio::socket_base::max_listen_connections, ec);
  if (ec) return refusal(ec);
  port_ = acceptor_.local_endpoint().port();
  host_ = address.host;
  on_loopback_ = IsLoopbackHost(address.host);
  pool_.emplace(static_cast<std::size_t>(options_.limits.pool_threads));
  Tick();
  asio::co_spawn(io_, Accept(), asio::detached);
  asio::co_spawn(io_, Sweep(), asio::detached);
  started_ = true;
  thread_ = std::thread([this] { io_.run(); });
  return core::Done{};
}

void HttpServer::Impl::CloseAll() {
  stopping_ = true;
  error_code ec;
  acceptor_.close(ec);
  const std::vector<Session*> all(sessions_.begin(), sessions_.end());
  for (Session* session : all) session->CloseIfIdle();
  sweep_timer_.cancel();
}

void HttpServer::Impl::Stop() {
  if (!started_) return;
  started_ = false;
  asio::post(io_, [this] { CloseAll(); });
  pool_->join();
  asio::steady_timer hard_stop(io_, std::chrono::seconds(1));
  hard_stop.async_wait([this](const error_code& ec) {
    if (!ec) io_.stop();
  });
  thread_.join();
}

HttpCounters HttpServer::Impl::counters() const {
  HttpCounters out;
  out.connections_accepted = counters_.accepted;
  out.connections_refused = counters_.refused;
  out.connections_open = counters_.open;
  out.requests = counters_.requests;
  out.deadlines_missed = counters_.deadlines;
  out.pool_refused = counters_.pool_refused;
  out.pool_waiting = pool_waiting_;
  for (std::size_t i = 0; i < counters_.answers.size(); ++i) {
    out.answers_by_class[i] = counters_.answers[i];
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

core::Status HttpServer::Start() {
  return impl_->Start();
}

int HttpServer::port() const {
  return impl_->port_;
}

std::string HttpServer::address() const {
  const bool v6 = impl_->host_.find(':') != std::string::npos;
  return (v6 ? "[" + impl_->host_ + "]" : impl_->host_) + ":" + std::to_string(impl_->port_);
}

bool HttpServer::on_loopback() const {
  return impl_->on_loopback_;
}

void HttpServer::Stop() {
  impl_->Stop();
}

HttpCounters HttpServer::counters() const {
  return impl_->counters();
}

}  // namespace faultlab::server
