#include "server/net/paced_sender.h"

#include <array>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <optional>
#include <string>
#include <utility>

#include "server/net/response_head.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kInlineBodyBytes = 8 << 10;   ///< copied after the head: one buffer, one send
constexpr std::size_t kSendPieceBytes = 512 << 10;  ///< sent within one write_deadline
constexpr std::size_t kDiscardBytesMax = 4 << 20;   ///< discarded before closing, to avoid a reset

}  // namespace

PacedSender::Watch::Watch(PacedSender& sender,
                          const std::string& caller,
                          std::function<bool()> still_may)
    : sender_(sender) {
  sender_.look_due_ = false;
  if (!still_may) return;
  sender_.still_may_ = std::move(still_may);
  sender_.asks_for_ = caller;
  sender_.look_at_ = sender_.host_.now + sender_.host_.options.limits.look_every;
}

void PacedSender::LookIfDue() {
  if (!still_may_ || host_.now < look_at_) return;
  look_at_ = host_.now + host_.options.limits.look_every;
  look_due_ = true;
  error_code ec;
  socket_.cancel(ec);  // Send continues after the check
}

/// @returns false when the connection has been cut
asio::awaitable<bool> PacedSender::CutWhenItMayNot() {
  if (!std::exchange(look_due_, false)) co_return true;
  const HandlerPool::Turn turn{asks_for_};
  if (host_.pool.RoomFor(turn) != HandlerPool::Room::kFree) co_return true;  // checked next time
  if (co_await host_.pool.Run(host_.io, turn, still_may_)) co_return true;
  error_code ec;
  // The data that waits in the kernel is discarded too.
  socket_.set_option(asio::socket_base::linger(true, 0), ec);
  socket_.close(ec);
  co_return false;
}

asio::awaitable<bool> PacedSender::Send(std::string_view bytes) {
  if (!co_await CutWhenItMayNot()) co_return false;
  error_code ec;
  const std::size_t sent = socket_.write_some(asio::buffer(bytes.data(), bytes.size()), ec);
  if (!ec && sent == bytes.size()) co_return true;
  if (ec && ec != asio::error::would_block) co_return false;
  bytes.remove_prefix(ec ? 0 : sent);
  while (!bytes.empty()) {
    std::string_view piece = bytes.substr(0, kSendPieceBytes);
    bytes.remove_prefix(piece.size());
    Deadline(host_.options.limits.write_deadline);
    while (!piece.empty()) {
      ec = {};
      piece.remove_prefix(
          co_await asio::async_write(socket_,
                                     asio::buffer(piece.data(), piece.size()),
                                     asio::redirect_error(asio::use_awaitable, ec)));
      const bool interrupted = ec == asio::error::operation_aborted && socket_.is_open();
      if (ec && !interrupted) co_return false;
      if (!co_await CutWhenItMayNot()) co_return false;
    }
  }
  co_return true;
}

asio::awaitable<bool> PacedSender::Send(const HttpResponse& response,
                                        bool to_head,
                                        bool keep_alive,
                                        const std::string& caller) {
  ++host_.counters.answers[static_cast<std::size_t>(response.status / 100) % 6];
  const std::string_view payload = response.payload();
  const bool bodyless = to_head || response.status == 304 || response.status == 204;
  const bool joined = !bodyless && !response.spool && payload.size() <= kInlineBodyBytes;
  const std::string head = EncodeResponseHead(response, host_.date, keep_alive, joined);
  if (!co_await Send(head)) co_return false;
  if (joined || bodyless) co_return true;
  if (response.spool) co_return co_await SendSpool(*response.spool, caller);
  co_return co_await Send(payload);
}

/// The disk is read on the pool, because the network thread must not wait for it.
asio::awaitable<bool> PacedSender::SendSpool(const Spool& spool, const std::string& caller) {
  constexpr std::chrono::milliseconds kPoolPause{100};
  const HandlerPool::Turn turn{caller};
  for (std::uint64_t at = 0; at < spool.size();) {
    Deadline(host_.options.limits.write_deadline);
    if (host_.pool.RoomFor(turn) != HandlerPool::Room::kFree) {
      asio::steady_timer pause(host_.io, kPoolPause);
      error_code ec;
      co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ec));
      if (!socket_.is_open()) co_return false;
      continue;
    }
    const std::optional<std::string> piece = co_await host_.pool.Run(
        host_.io, turn, [&spool, at] { return spool.Read(at, kSendPieceBytes); });
    // The promised length cannot be sent; only the end of the connection can show this.
    if (!piece || piece->empty()) co_return false;
    if (!co_await Send(*piece)) co_return false;
    at += piece->size();
  }
  co_return true;
}

asio::awaitable<void> PacedSender::Refuse(HttpResponse response, bool to_head) {
  if (!co_await Send(response, to_head, false, {})) co_return;
  error_code ec;
  socket_.shutdown(tcp::socket::shutdown_send, ec);
  if (ec) co_return;
  Deadline(kLinger);
  std::array<char, 16 << 10> waste;
  for (std::size_t total = 0; total < kDiscardBytesMax;) {
    const std::size_t got = co_await socket_.async_read_some(
        asio::buffer(waste), asio::redirect_error(asio::use_awaitable, ec));
    if (ec) co_return;
    total += got;
  }
}

}  // namespace faultlab::server
