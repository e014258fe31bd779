// How a connection reads a request: header, client, body.
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cstdint>
#include <iterator>
#include <utility>

#include "server/address_key.h"
#include "server/clock.h"
#include "server/net/connection.h"
#include "server/net/forwarded_for.h"
#include "server/net/framing_allowance.h"
#include "server/net/refusals.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;

constexpr std::size_t kReadBytes = 4096;
constexpr std::size_t kBodyReadBytes = 64 << 10;
/// Step by which the budget is taken in advance.
constexpr std::size_t kBodyStepBytes = 64 << 10;

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

/// Refuses a request whose length two readers could understand differently, or that names two
/// hosts.
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

}  // namespace

asio::awaitable<bool> Connection::ReadMore(std::size_t bytes) {
  error_code ec;
  const std::size_t got = co_await socket_.async_read_some(
      buffer_.prepare(bytes), asio::redirect_error(asio::use_awaitable, ec));
  if (ec || got == 0) co_return false;
  buffer_.commit(got);
  co_return true;
}

asio::awaitable<bool> Connection::ReadHeader() {
  request_.method = HttpMethod::kGet;  // until known; a refusal then has a body
  caller_ = address_key_;
  caller_is_known_ = false;
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(host_.options.limits.header_bytes_max));
  // The limit of the body depends on the route; Serve checks it before a byte of the body is read.
  parser_->body_limit(boost::none);
  for (;;) {
    if (buffer_.size() > 0) {
      error_code ec;
      buffer_.consume(parser_->put(buffer_.data(), ec));
      if (parser_->is_header_done()) {
        slow_ = {};
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
        WaitFor(address_key_);
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
  FramingAllowance framing;
  ClientCounts::Place slow_body;
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
    const std::size_t body_bytes = parser_->get().body().size();
    // When the message is complete, the rest of the buffer is the next request.
    if (!framing.Covers(used, body_bytes, parser_->is_done() ? 0 : buffer_.size())) {
      co_await Refuse(
          Problem(400, "bad_request", "Bad body", "Chunk extensions and trailers are too long."));
      co_return false;
    }
    if (!HoldBody(body_bytes + buffer_.size())) {
      ++host_.counters.bytes_refused;
      co_await Refuse(BytesFullProblem());
      co_return false;
    }
    if (parser_->is_done() || used > 0) continue;
    if (!slow_body.taken()) {
      if (host_.slow_bodies.Of(caller_) >= host_.options.limits.slow_bodies_per_caller_max) {
        co_await Refuse(SlowBodiesProblem());
        co_return false;
      }
      slow_body = host_.slow_bodies.Take(caller_);
      WaitFor(caller_);
    }
    if (!co_await ReadMore(kBodyReadBytes)) co_return false;
  }
  slow_ = {};
  co_return true;
}

/// Takes budget for what has arrived, in steps; a small body does not need it.
bool Connection::HoldBody(std::size_t bytes) {
  if (bytes <= kSmallBytes || bytes <= body_bytes_.bytes()) return true;
  const std::size_t wanted = bytes + kBodyStepBytes;
  auto hold = host_.TakeBytes(wanted - body_bytes_.bytes(), *this);
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
  caller_ = address_key_;
  caller_is_known_ = false;
  if (!behind_proxy_ || !request_.Header(kHopHeader).empty()) return;
  // The proxy's own entry is the last: it may add a line, or an entry to the client's line.
  if (const std::string_view list = LastHeader("X-Forwarded-For"); !list.empty()) {
    request_.remote_address = ForwardedAddress(LastListEntry(list));
    caller_ = AddressKey(request_.remote_address);
    request_.https = LastListEntry(LastHeader("X-Forwarded-Proto")) == "https";
  } else if (!LastHeader("Forwarded").empty() || !LastHeader("X-Real-IP").empty()) {
    request_.remote_address =
        kUnknownClient;  // a proxy that says it elsewhere, where we do not look
    caller_ = AddressKey(request_.remote_address);
  }
}

std::string_view Connection::LastHeader(std::string_view name) const {
  for (auto header = request_.headers.rbegin(); header != request_.headers.rend(); ++header) {
    if (EqualNoCase(header->first, name)) return header->second;
  }
  return {};
}

/// Reads the client's address from the server that passed the request on. A hop without a valid
/// seal is refused and not ignored, because otherwise the request would be treated as that server's
/// own.
/// @returns false when there is a hop without a valid seal
bool Connection::ReadHop() {
  const std::string_view value = request_.Header(kHopHeader);
  if (value.empty()) return true;
  const auto hop =
      host_.seal ? host_.seal->Open(value, request_, SystemClock().Wall()) : std::nullopt;
  if (!hop) return false;
  hop_client_ = hop->client;
  hop_body_hash_ = hop->body_hash;
  request_.remote_address = hop_client_;
  caller_ = AddressKey(hop_client_);
  request_.https = hop->https;
  request_.from_peer = true;
  return true;
}

bool Connection::HasBodyOfHop() const {
  return !request_.from_peer || BodyHash(request_.body) == hop_body_hash_;
}

}  // namespace faultlab::server
