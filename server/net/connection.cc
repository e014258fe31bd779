#include "server/net/connection.h"

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cstdint>
#include <exception>
#include <iterator>
#include <utility>
#include <variant>

#include "server/address_key.h"
#include "server/clock.h"
#include "server/net/admission_desk.h"
#include "server/net/listen_address.h"
#include "server/net/passing_on.h"
#include "server/net/refusals.h"
#include "server/net/response_head.h"

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
constexpr std::size_t kSmallBytes = 64 << 10;  ///< what waits without asking the budget
/// Asked of the budget ahead of what has arrived.
constexpr std::size_t kBodyStepBytes = 256 << 10;

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

/// A request that two readers could cut in two ways, or that names two hosts.
std::optional<HttpResponse> FramingRefusal(const beast::http::request_header<>& header) {
  using beast::http::field;
  const auto lines = [&header](field name) {
    const auto range = header.equal_range(name);
    return std::distance(range.first, range.second);
  };
  const char* text = nullptr;
  if (lines(field::host) > 1) text = "The request has more than one Host header.";
  if (lines(field::transfer_encoding) > 0) {
    if (lines(field::transfer_encoding) > 1 || header.version() < 11 ||
        !EqualNoCase(View(header[field::transfer_encoding]), "chunked")) {
      text = "The only Transfer-Encoding here is \"chunked\".";
    }
  }
  if (text == nullptr) return std::nullopt;
  return Problem(400, "bad_request", "Not HTTP/1.1", text);
}

std::string_view LastListEntry(std::string_view list) {
  const std::size_t comma = list.rfind(',');
  std::string_view entry = comma == std::string_view::npos ? list : list.substr(comma + 1);
  while (entry.starts_with(' ')) entry.remove_prefix(1);
  return entry;
}

}  // namespace

Connection::Connection(ConnectionHost& host, tcp::socket socket)
    : host_(host), socket_(std::move(socket)), sender_(host_, socket_, deadline_) {
  host_.connections.insert(this);
  ++host_.counters.open;
  error_code ec;
  socket_.set_option(tcp::no_delay(true), ec);
  socket_.non_blocking(true, ec);
  const auto peer = socket_.remote_endpoint(ec);
  if (!ec) {
    const auto address = peer.address();
    peer_address_ = address.to_string();
    behind_proxy_ = address.is_loopback() || host_.options.trusted_proxies.Has(peer_address_);
    address_key_ = AddressKey(peer_address_);
    ++host_.of_address[address_key_];
  }
}

Connection::~Connection() {
  host_.connections.erase(this);
  const auto count = host_.of_address.find(address_key_);
  if (count != host_.of_address.end() && --count->second == 0) host_.of_address.erase(count);
  --host_.counters.open;
}

void Connection::Close() {
  error_code ec;
  socket_.close(ec);
}

void Connection::CloseIfLate() {
  if (host_.now < deadline_) return;
  ++host_.counters.deadlines;
  if (reading_request_) {
    // Best effort: a socket that takes no bytes now is closed without them.
    const HttpResponse late = Problem(
        408, "timeout", "Request timeout", "The request did not arrive in time; send it faster.");
    const std::string bytes = EncodeResponseHead(late, host_.date, false, true);
    error_code ec;
    socket_.write_some(asio::buffer(bytes), ec);
  }
  Close();
}

void Connection::CloseIfIdle() {
  last_request_ = true;
  if (idle_) Close();
}

asio::awaitable<bool> Connection::ReadMore(std::size_t bytes) {
  error_code ec;
  const std::size_t got = co_await socket_.async_read_some(
      buffer_.prepare(bytes), asio::redirect_error(asio::use_awaitable, ec));
  if (ec || got == 0) co_return false;
  buffer_.commit(got);
  co_return true;
}

asio::awaitable<bool> Connection::ReadHeader() {
  request_.method = HttpMethod::kGet;  // until known: a refusal then carries its body
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(host_.options.limits.header_bytes_max));
  // The limit of the body depends on the route: checked by Serve before a byte of it is taken.
  parser_->body_limit(boost::none);
  for (;;) {
    if (buffer_.size() > 0) {
      error_code ec;
      buffer_.consume(parser_->put(buffer_.data(), ec));
      if (parser_->is_header_done()) {
        if (auto refusal = FramingRefusal(parser_->get())) {
          co_await Refuse(std::move(*refusal));
          co_return false;
        }
        co_return true;
      }
      if (ec == beast::http::error::header_limit) {
        co_await Refuse(Problem(431,
                                "header_too_large",
                                "Header too large",
                                "Request line and headers together may have at most " +
                                    std::to_string(host_.options.limits.header_bytes_max) +
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
        Deadline(host_.options.limits.header_deadline);
      }
    }
    if (!co_await ReadMore(kReadBytes)) co_return false;
    idle_ = false;
  }
}

asio::awaitable<bool> Connection::ReadBody(std::size_t bytes_max) {
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
    if (!co_await sender_.Send("HTTP/1.1 100 Continue\r\n\r\n")) co_return false;
  }
  reading_request_ = true;
  Deadline(host_.options.limits.body_deadline);
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
    if (!HoldBody(parser_->get().body().size())) {
      ++host_.counters.bytes_refused;
      co_await Refuse(BytesFullProblem());
      co_return false;
    }
    if (parser_->is_done() || used > 0) continue;
    if (!co_await ReadMore(kBodyReadBytes)) co_return false;
  }
  co_return true;
}

/// The budget is asked for what has arrived, in steps; a small body is never in its way.
bool Connection::HoldBody(std::size_t bytes) {
  if (bytes <= kSmallBytes || bytes <= body_bytes_.bytes()) return true;
  const std::size_t wanted = bytes + kBodyStepBytes;
  auto hold = host_.waiting_bytes.Take(wanted - body_bytes_.bytes());
  if (!hold) return false;
  body_bytes_.Add(std::move(*hold));
  return true;
}

void Connection::FillRequest() {
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
  request_.remote_address = peer_address_;
  request_.https = false;
  request_.from_peer = false;
  if (!behind_proxy_ || !request_.Header(kHopHeader).empty()) return;
  // What the proxy itself says stands last: it may add a line, or an entry to the client's.
  if (const std::string_view list = LastHeader("X-Forwarded-For"); !list.empty()) {
    request_.remote_address = LastListEntry(list);
    request_.https = LastListEntry(LastHeader("X-Forwarded-Proto")) == "https";
  }
}

std::string_view Connection::LastHeader(std::string_view name) const {
  for (auto header = request_.headers.rbegin(); header != request_.headers.rend(); ++header) {
    if (EqualNoCase(header->first, name)) return header->second;
  }
  return {};
}

/// Who the client is says the server that passed the request on. A hop that is not sealed by one is
/// refused and not ignored: read without it, the request would be that server's own.
/// @returns false when there is a hop that is not believed.
bool Connection::ReadHop() {
  const std::string_view value = request_.Header(kHopHeader);
  if (value.empty()) return true;
  const auto hop =
      host_.seal ? host_.seal->Open(value, request_, SystemClock().Wall()) : std::nullopt;
  if (!hop) return false;
  hop_client_ = hop->client;
  request_.remote_address = hop_client_;
  request_.https = hop->https;
  request_.from_peer = true;
  return true;
}

RouteAnswer Connection::Handle(const Route& route) const {
  try {
    return route.handle(request_);
  } catch (const std::exception& error) {
    host_.Report(std::string("handler of ") + route.pattern + ": " + error.what());
    return InternalProblem();
  }
}

asio::awaitable<void> Connection::Refuse(HttpResponse response) {
  reading_request_ = false;
  return sender_.Refuse(std::move(response), request_.method == HttpMethod::kHead);
}

asio::awaitable<bool> Connection::Admit(const Route& route) {
  deadline_ = Steady::time_point::max();
  Admission admission = co_await AskAdmission(host_, route, request_, caller_);
  if (admission.refusal) {
    co_await Refuse(std::move(*admission.refusal));
    co_return false;
  }
  admitted_ = std::move(admission.held);
  if (!admission.caller.empty()) caller_ = std::move(admission.caller);
  co_return true;
}

asio::awaitable<HttpResponse> Connection::Answer(const Route& route) {
  RouteAnswer answer;
  if (route.runs_on == RunsOn::kInline) {
    answer = Handle(route);
  } else {
    HandlerPool& pool = host_.PoolOf(route.runs_on);
    if (auto full = PoolRefusal(host_, pool, caller_)) co_return std::move(*full);
    answer = co_await pool.Run(host_.io, caller_, [this, &route] { return Handle(route); });
  }
  if (const auto* ask = std::get_if<AskPeers>(&answer)) {
    co_return co_await PassOn(host_, request_, *ask);
  }
  co_return std::move(std::get<HttpResponse>(answer));
}

asio::awaitable<Connection::Next> Connection::Serve() {
  FillRequest();
  ++host_.counters.requests;
  const std::string_view host = request_.Header("Host");
  if (!HostAllowed(host, host_.options.allowed_hosts, host_.on_loopback)) {
    co_await Refuse(Problem(421,
                            "unknown_host",
                            "Unknown host",
                            "This server does not answer to the name in the Host header; add it to "
                            "allowed_hosts."));
    co_return Next::kClose;
  }
  if (!ReadHop()) {
    co_await Refuse(
        Problem(403,
                "foreign_hop",
                "Foreign hop",
                "This request says that a server of this lab passed it on, and none did "
                "just now. Servers that share a database keep their clocks by NTP."));
    co_return Next::kClose;
  }
  caller_ = AddressKey(request_.remote_address);
  if (!request_.Header("Upgrade").empty() && request_.Header("Upgrade") == "websocket") {
    co_return co_await Upgrade();
  }
  const bool safe = request_.method == HttpMethod::kGet || request_.method == HttpMethod::kHead;
  if (!safe && !OriginAllowed(request_.Header("Origin"), host)) {
    co_await Refuse(Problem(
        403, "foreign_origin", "Foreign origin", "A page of another site may not do this here."));
    co_return Next::kClose;
  }
  const Router::Match match = host_.router.Find(request_);
  const bool body_is_here =
      parser_->is_done() || parser_->content_length().value_or(SIZE_MAX) <= buffer_.size();
  if (match.route != nullptr && match.route->admit &&
      (match.route->always_admit || !body_is_here)) {
    if (!co_await Admit(*match.route)) co_return Next::kClose;
  }
  if (!co_await ReadBody(match.route != nullptr ? match.route->body_bytes_max : 0)) {
    co_return Next::kClose;
  }
  reading_request_ = false;
  deadline_ = Steady::time_point::max();  // the handler's time is ours, not the client's
  request_.body = parser_->get().body();
  const bool keep_alive = parser_->get().keep_alive() && !last_request_;
  HttpResponse response;
  if (match.route != nullptr) {
    response = co_await Answer(*match.route);
  } else if (!match.allow.empty()) {
    response = Problem(405,
                       "method_not_allowed",
                       "Method not allowed",
                       "This address answers to " + match.allow + ".");
    response.headers.emplace_back("Allow", match.allow);
  } else {
    response = Problem(404, "not_found", "Not found", "There is nothing at this address.");
  }
  // Until it is sent to its end. A small answer is never in the way of the budget, and what a
  // request has changed is told whatever it says.
  std::optional<ByteBudget::Hold> hold;
  if (safe && response.body.size() > kSmallBytes) {
    hold = host_.waiting_bytes.Take(response.body.size());
    if (!hold) {
      ++host_.counters.bytes_refused;
      response = BytesFullProblem();
    }
  }
  if (request_.https) {
    response.headers.emplace_back("Strict-Transport-Security", "max-age=31536000");
  }
  Deadline(host_.options.limits.write_deadline);
  const bool sent =
      co_await sender_.Send(response, request_.method == HttpMethod::kHead, keep_alive, caller_);
  body_bytes_ = {};
  admitted_.reset();
  if (!sent) co_return Next::kClose;
  co_return keep_alive ? Next::kKeepAlive : Next::kClose;
}

asio::awaitable<void> Connection::Run() {
  for (;;) {
    idle_ = buffer_.size() == 0;
    // A connection that waits keeps neither the last body nor the buffer it came through.
    if (idle_ && buffer_.capacity() > kIdleBufferBytesMax) buffer_.shrink_to_fit();
    idle_since_ = host_.now;
    reading_request_ = false;
    Deadline(host_.options.limits.idle_deadline);
    if (!co_await ReadHeader()) co_return;
    idle_ = false;
    const Next next = co_await Serve();
    if (next == Next::kUpgraded) co_return;
    if (next == Next::kClose || last_request_) break;
  }
  error_code ec;
  socket_.shutdown(tcp::socket::shutdown_both, ec);
}

}  // namespace faultlab::server
