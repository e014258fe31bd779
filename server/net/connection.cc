#include "server/net/connection.h"

#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <charconv>
#include <exception>
#include <utility>
#include <variant>

#include "server/address_key.h"
#include "server/net/admission.h"
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

constexpr std::size_t kIdleBufferBytesMax = 16 << 10;
/// Between two looks at what somebody waits for: it is told within a tenth of a second at first,
/// within half a second later.
constexpr std::chrono::milliseconds kFirstPause{50};
constexpr std::chrono::milliseconds kLongestPause{500};

/// Out of the answer of another server.
void TakePatience(HttpResponse& answer) {
  const auto told = std::ranges::find(
      answer.headers, std::string(kPatienceHeader), &std::pair<std::string, std::string>::first);
  if (told == answer.headers.end()) return;
  int seconds = 0;
  std::from_chars(told->second.data(), told->second.data() + told->second.size(), seconds);
  answer.patience = std::chrono::seconds(seconds);
  answer.headers.erase(told);
}

/// It is the other server that waits.
void TellPatience(HttpResponse& answer) {
  if (answer.patience.count() == 0) return;
  answer.headers.emplace_back(std::string(kPatienceHeader),
                              std::to_string(answer.patience.count()));
  answer.patience = {};
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
    place_ = host_.of_address.Take(address_key_);
  }
}

Connection::~Connection() {
  host_.connections.erase(this);
  --host_.counters.open;
}

void Connection::Close() {
  error_code ec;
  socket_.close(ec);
}

void Connection::GiveUp() {
  body_bytes_ = {};
  answer_bytes_ = {};
  Close();
}

void Connection::WaitFor(const std::string& client) {
  slow_ = host_.slow_clients.Take(client);
  waits_since_ = host_.now;
}

void Connection::Sweep() {
  sender_.LookIfDue();
  if (host_.now < deadline_) return;
  ++host_.counters.deadlines;
  if (reading_request_) {
    // Best effort: if the socket accepts no bytes now, it is closed without them.
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

RouteAnswer Connection::Handle(const Route& route) const {
  try {
    return route.handle(request_);
  } catch (const std::exception& error) {
    host_.Report(std::string("handler of ") + route.pattern + ": " + error.what());
    return InternalProblem();
  }
}

/// The check that the sender repeats from time to time; empty when no permission can end.
std::function<bool()> Connection::StillMay(const Route* route) const {
  if (route == nullptr || !route->still_may) return {};
  return [this, route] {
    try {
      return route->still_may(request_);
    } catch (const std::exception& error) {
      host_.Report(std::string("the right to ") + route->pattern + ": " + error.what());
      return true;
    }
  };
}

asio::awaitable<void> Connection::Refuse(HttpResponse response) {
  reading_request_ = false;
  if (!slow_.taken()) WaitFor(caller_);
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
  caller_is_known_ = admission.known;
  co_return true;
}

asio::awaitable<HttpResponse> Connection::AnswerOnce(const Route& route) {
  RouteAnswer answer;
  if (route.runs_on == RunsOn::kInline) {
    answer = Handle(route);
  } else {
    HandlerPool& pool = host_.PoolOf(route.runs_on);
    const HandlerPool::Turn turn{
        caller_, route.lane.empty() ? std::string() : request_.PathParameter(route.lane)};
    if (auto full = PoolRefusal(host_, pool, turn)) co_return std::move(*full);
    answer = co_await pool.Run(host_.io, turn, [this, &route] { return Handle(route); });
  }
  if (const auto* ask = std::get_if<AskPeers>(&answer)) {
    const std::string& asker = ask->caller.empty() ? caller_ : ask->caller;
    HttpResponse passed = co_await PassOn(host_, request_, *ask, asker);
    TakePatience(passed);
    co_return passed;
  }
  co_return std::move(std::get<HttpResponse>(answer));
}

/// It has left, or asks nothing more: what is known now is sent.
bool Connection::HasPeerClosedItsHalf() {
  char byte = 0;
  return recv(socket_.native_handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

asio::awaitable<HttpResponse> Connection::Answer(const Route& route) {
  HttpResponse answer = co_await AnswerOnce(route);
  if (request_.from_peer) TellPatience(answer);
  if (answer.patience.count() == 0) co_return answer;
  const HttpLimits& limits = host_.options.limits;
  const bool room =
      host_.waits.all() < limits.waits_max && host_.waits.Of(caller_) < limits.waits_per_caller_max;
  const ClientCounts::Place place = room ? host_.waits.Take(caller_) : ClientCounts::Place();
  host_.counters.waits = host_.waits.all();
  // Without room for a long wait a short one, so that nobody asks as fast as the network goes.
  const auto until =
      Steady::now() + (room ? Steady::duration(answer.patience) : Steady::duration(kLongestPause));
  auto pause = kFirstPause;
  while (!last_request_ && Steady::now() < until) {
    answer = {};  // it holds no memory meanwhile
    asio::steady_timer timer(host_.io, std::min<Steady::duration>(pause, until - Steady::now()));
    error_code ec;
    idle_ = true;
    waits_since_ = host_.now;
    co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, ec));
    idle_ = false;
    if (!socket_.is_open()) break;  // closed to make room
    const bool last = HasPeerClosedItsHalf();
    answer = co_await AnswerOnce(route);
    if (last) break;
    const bool no_room = answer.status == 429 || answer.status == 503;
    if (answer.patience.count() == 0 && !no_room) break;
    pause = no_room ? kLongestPause : std::min(pause * 3 / 2, kLongestPause);
  }
  host_.counters.waits = host_.waits.all() - (room ? 1 : 0);
  co_return answer;
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
  const auto foreign_hop = [] {
    return Problem(403,
                   "foreign_hop",
                   "Foreign hop",
                   "This request says that a server of this lab passed it on, and none did "
                   "just now. Servers that share a database keep their clocks by NTP.");
  };
  if (!ReadHop()) {
    co_await Refuse(foreign_hop());
    co_return Next::kClose;
  }
  if (!request_.Header("Upgrade").empty() && request_.Header("Upgrade") == "websocket") {
    co_return co_await Upgrade();
  }
  const Router::Match match = host_.router.Find(request_);
  const bool safe = request_.method == HttpMethod::kGet || request_.method == HttpMethod::kHead;
  const bool from_anywhere = match.route != nullptr && match.route->from_anywhere;
  if (!safe && !from_anywhere && !OriginAllowed(request_.Header("Origin"), host)) {
    co_await Refuse(Problem(
        403, "foreign_origin", "Foreign origin", "A page of another site may not do this here."));
    co_return Next::kClose;
  }
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
  deadline_ = Steady::time_point::max();  // the handler has no deadline here
  request_.body = parser_->get().body();
  if (!HasBodyOfHop()) {
    co_await Refuse(foreign_hop());
    co_return Next::kClose;
  }
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
  // Held until the answer is completely sent. A small answer does not need the budget, and the
  // answer to a request that has changed something is always sent.
  if (safe && response.body.size() > kSmallBytes) {
    auto hold = host_.TakeBytes(response.body.size(), *this);
    if (hold) {
      answer_bytes_ = std::move(*hold);
    } else {
      ++host_.counters.bytes_refused;
      response = BytesFullProblem();
    }
  }
  if (request_.https) {
    response.headers.emplace_back("Strict-Transport-Security", "max-age=31536000");
  }
  Deadline(host_.options.limits.write_deadline);
  WaitFor(caller_);
  const PacedSender::Watch watch(sender_, caller_, StillMay(safe ? match.route : nullptr));
  const bool sent =
      co_await sender_.Send(response, request_.method == HttpMethod::kHead, keep_alive, caller_);
  slow_ = {};
  body_bytes_ = {};
  answer_bytes_ = {};
  admitted_.reset();
  if (!sent) co_return Next::kClose;
  co_return keep_alive ? Next::kKeepAlive : Next::kClose;
}

asio::awaitable<void> Connection::Run() {
  for (;;) {
    idle_ = buffer_.size() == 0;
    // A waiting connection keeps neither the last body nor its read buffer.
    if (idle_ && buffer_.capacity() > kIdleBufferBytesMax) buffer_.shrink_to_fit();
    waits_since_ = host_.now;
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
