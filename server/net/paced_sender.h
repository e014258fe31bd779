#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// Sends answers to one client, each piece by a deadline of its own: a client that takes one more
/// slowly than the slowest line served is given up.
class PacedSender {
 public:
  /// @param deadline  of the connection, which closes it when the time has come
  PacedSender(ConnectionHost& host,
              boost::asio::ip::tcp::socket& socket,
              std::chrono::steady_clock::time_point& deadline)
      : host_(host), socket_(socket), deadline_(deadline) {}

  /// False when the client is gone.
  boost::asio::awaitable<bool> Send(std::string_view bytes);
  /// @param to_head  the request was HEAD: no payload
  /// @param caller  for whom a spooled payload is read
  boost::asio::awaitable<bool> Send(const HttpResponse& response,
                                    bool to_head,
                                    bool keep_alive,
                                    const std::string& caller);
  /// Answers and ends the connection without a reset: what the client still sends is read away for
  /// a while, for a reset would take the answer from under its eyes.
  boost::asio::awaitable<void> Refuse(HttpResponse response, bool to_head);

  /// While it lives, `still_may` is asked every `look_every`, on the pool, for `caller`; when it
  /// says no, the connection is cut. An empty one is not asked.
  class Watch {
   public:
    Watch(PacedSender& sender, const std::string& caller, std::function<bool()> still_may);
    ~Watch() { sender_.still_may_ = {}; }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

   private:
    PacedSender& sender_;
  };
  /// Has the question asked when it is time. Of whoever looks at the clock, between two steps of
  /// this sender.
  void LookIfDue();

 private:
  boost::asio::awaitable<bool> CutWhenItMayNot();
  boost::asio::awaitable<bool> SendSpool(const Spool& spool, const std::string& caller);
  void Deadline(std::chrono::milliseconds from_now) { deadline_ = host_.now + from_now; }

  ConnectionHost& host_;
  boost::asio::ip::tcp::socket& socket_;
  std::chrono::steady_clock::time_point& deadline_;
  std::function<bool()> still_may_;
  std::string asks_for_;  ///< the caller, while there is a question
  std::chrono::steady_clock::time_point look_at_{};
  bool look_due_ = false;
};

/// Until a refused or closing client is gone.
inline constexpr std::chrono::milliseconds kLinger{2000};

}  // namespace faultlab::server
