#include "server/net/peer.h"

#include <algorithm>
#include <array>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <utility>

#include "server/net/forwarding_seal.h"
#include "server/net/framing_allowance.h"
#include "server/net/listen_address.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kPeerReadBytes = 16 << 10;
constexpr std::size_t kHeaderBytesMax = 16 << 10;
/// For a tunnel: data that waits in the kernel is already old when it is read.
constexpr int kSocketBufferBytes = 64 << 10;

/// Headers of a request that a handler may read. The others belong to this connection (Connection,
/// TE, ..) or would let a client make statements about itself (X-Forwarded-For, X-Faultlab-Hop).
constexpr std::array<std::string_view, 15> kRequestHeaders = {"Host",
                                                              "Cookie",
                                                              "Authorization",
                                                              "X-CSRF-Token",
                                                              "Origin",
                                                              "Content-Type",
                                                              "Idempotency-Key",
                                                              "If-Match",
                                                              "If-None-Match",
                                                              "Accept",
                                                              "User-Agent",
                                                              "Upgrade",
                                                              "Sec-WebSocket-Key",
                                                              "Sec-WebSocket-Version",
                                                              "Sec-WebSocket-Protocol"};
/// Headers that a handler may set; each server writes the rest of an answer's head itself.
constexpr std::array<std::string_view, 10> kAnswerHeaders = {"Content-Type",
                                                             "Location",
                                                             "Retry-After",
                                                             "ETag",
                                                             "Cache-Control",
                                                             "Content-Disposition",
                                                             "WWW-Authenticate",
                                                             "Idempotency-Replayed",
                                                             kPatienceHeader,
                                                             "X-Picture-Age-Ms"};

template <std::size_t N>
std::string_view Known(const std::array<std::string_view, N>& names, std::string_view name) {
  const auto found = std::ranges::find_if(
      names, [name](std::string_view known) { return EqualNoCase(known, name); });
  return found == names.end() ? std::string_view() : *found;
}

std::string Encode(const HttpRequest& request, std::string_view hop) {
  const bool upgrade = !request.Header("Upgrade").empty();
  const HttpMethod method = request.method == HttpMethod::kHead ? HttpMethod::kGet : request.method;
  std::string out;
  out.reserve(2048 + request.body.size());
  out.append(Name(method)).append(" ").append(request.target).append(" HTTP/1.1\r\n");
  for (const auto& [name, value] : request.headers) {
    const std::string_view known = Known(kRequestHeaders, name);
    if (!known.empty()) out.append(known).append(": ").append(value).append("\r\n");
  }
  out.append(kHopHeader).append(": ").append(hop);
  out.append("\r\nConnection: ").append(upgrade ? "Upgrade" : "close");
  if (!upgrade) out.append("\r\nContent-Length: ").append(std::to_string(request.body.size()));
  out.append("\r\n\r\n").append(request.body);
  return out;
}

/// Reads from one end and writes to the other until one of them ends.
asio::awaitable<void> Pump(tcp::socket& from,
                           tcp::socket& to,
                           const std::function<void()>& heard,
                           const std::function<void()>& ending) {
  std::array<char, kPeerReadBytes> buffer;
  error_code ec;
  while (true) {
    const std::size_t got = co_await from.async_read_some(
        asio::buffer(buffer), asio::redirect_error(asio::use_awaitable, ec));
    if (ec) break;
    if (heard) heard();
    co_await asio::async_write(
        to, asio::buffer(buffer.data(), got), asio::redirect_error(asio::use_awaitable, ec));
    if (ec) break;
  }
  error_code ignored;
  if (ec == asio::error::eof) {
    // The last bytes are on their way to the other end, which now closes as well.
    to.shutdown(tcp::socket::shutdown_send, ignored);
    ending();
  } else {
    from.close(ignored);
    to.close(ignored);
  }
}

}  // namespace

/// Closes the socket when its time has passed; ends with this object.
class PeerExchange::Deadline {
 public:
  Deadline(PeerExchange& exchange, std::chrono::milliseconds from_now) : timer_(exchange.io_) {
    timer_.expires_after(from_now);
    timer_.async_wait([socket = exchange.socket_](const error_code& ec) {
      error_code ignored;
      if (!ec) socket->close(ignored);
    });
  }

 private:
  asio::steady_timer timer_;
};

PeerExchange::PeerExchange(asio::io_context& io, const PeerLimits& limits, const PeerAddress& peer)
    : io_(io), limits_(limits), peer_(peer), socket_(std::make_shared<tcp::socket>(io)) {}

core::Error PeerExchange::Unreachable() const {
  return {core::ErrorCode::kUnavailable,
          "Server '" + peer_.name +
              "' has what this is about and cannot be reached; try again in a few seconds.",
          "",
          "peer_silent"};
}

asio::awaitable<core::Status> PeerExchange::Connect() {
  if (peer_.address.empty()) {
    co_return core::Error{core::ErrorCode::kUnavailable,
                          "Server '" + peer_.name +
                              "' has what this is about and does not say where it can be reached; "
                              "set member_address in its settings.",
                          "",
                          "peer_silent"};
  }
  const auto parsed = ParseListenAddress(peer_.address);
  if (!parsed) co_return Unreachable();
  error_code ec;
  const tcp::endpoint endpoint(asio::ip::make_address(parsed.value().host, ec),
                               parsed.value().port);
  if (!ec) socket_->open(endpoint.protocol(), ec);
  if (!ec) socket_->set_option(tcp::no_delay(true), ec);
  // Before connecting, because the window is negotiated then.
  if (!ec) socket_->set_option(tcp::socket::receive_buffer_size(kSocketBufferBytes), ec);
  if (ec) co_return Unreachable();
  const Deadline deadline(*this, limits_.connect_deadline);
  co_await socket_->async_connect(endpoint, asio::redirect_error(asio::use_awaitable, ec));
  if (ec || !socket_->is_open()) co_return Unreachable();
  co_return core::Done{};
}

asio::awaitable<core::Result<HttpResponse>> PeerExchange::Ask(const HttpRequest& request,
                                                              std::string_view hop) {
  const core::Status connected = co_await Connect();
  if (!connected.ok()) co_return connected.error();
  const bool safe = request.method == HttpMethod::kGet || request.method == HttpMethod::kHead;
  const core::Error silence{
      core::ErrorCode::kUnavailable,
      safe ? "Server '" + peer_.name + "' does not answer; try again in a few seconds."
           : "Server '" + peer_.name +
                 "' has got this and does not answer: it may be done. Look before you ask again.",
      "",
      safe ? "peer_silent" : "peer_may_have_done"};
  const Deadline deadline(*this, safe ? limits_.answer_deadline : limits_.change_deadline);
  const std::string bytes = Encode(request, hop);
  error_code ec;
  co_await asio::async_write(
      *socket_, asio::buffer(bytes), asio::redirect_error(asio::use_awaitable, ec));
  // A refusal may come before the body is read, so the peer's answer is used.
  auto answer = co_await ReadAnswer(silence);
  co_return answer;
}

asio::awaitable<core::Result<HttpResponse>> PeerExchange::ReadAnswer(const core::Error& silence) {
  beast::http::response_parser<beast::http::string_body> parser;
  parser.header_limit(kHeaderBytesMax);
  parser.body_limit(limits_.answer_bytes_max);
  parser.eager(true);
  FramingAllowance framing;
  error_code ec;
  while (!parser.is_done()) {
    if (buffer_.size() > 0) {
      const bool in_body = parser.is_header_done();
      const std::size_t used = parser.put(buffer_.data(), ec);
      buffer_.consume(used);
      if (ec && ec != beast::http::error::need_more) co_return silence;
      if (parser.is_done()) break;
      const std::size_t body_bytes = parser.get().body().size();
      if (!framing.Covers(in_body ? used : body_bytes, body_bytes, buffer_.size())) {
        co_return silence;
      }
    }
    const std::size_t got = co_await socket_->async_read_some(
        buffer_.prepare(kPeerReadBytes), asio::redirect_error(asio::use_awaitable, ec));
    if (ec) co_return silence;
    buffer_.commit(got);
  }
  HttpResponse response;
  response.status = parser.get().result_int();
  response.content_type = {};  // it is among the headers
  for (const auto& field : parser.get()) {
    const std::string_view known = Known(
        kAnswerHeaders, std::string_view(field.name_string().data(), field.name_string().size()));
    if (known.empty()) continue;
    response.headers.emplace_back(known, std::string(field.value().data(), field.value().size()));
  }
  response.body = std::move(parser.get().body());
  co_return response;
}

std::string PeerExchange::pending() const {
  return {static_cast<const char*>(buffer_.data().data()), buffer_.size()};
}

asio::awaitable<void> Tunnel(tcp::socket& client,
                             tcp::socket& peer,
                             std::function<void()> heard,
                             std::function<void()> ending) {
  using asio::experimental::awaitable_operators::operator&&;
  error_code ignored;
  client.set_option(tcp::socket::send_buffer_size(kSocketBufferBytes), ignored);
  co_await (Pump(peer, client, heard, ending) && Pump(client, peer, {}, ending));
}

}  // namespace faultlab::server
