#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// Sends answers to one client, each piece with its own deadline: a client that reads more slowly
/// than the minimum rate is disconnected.
class PacedSender {
 public:
  /// @param deadline  of the connection, which closes itself when it has passed
  PacedSender(ConnectionHost& host,
              boost::asio::ip::tcp::socket& socket,
              std::chrono::steady_clock::time_point& deadline)
      : host_(host), socket_(socket), deadline_(deadline) {}

  /// False when the client is gone.
  boost::asio::awaitable<bool> Send(std::string_view bytes);
  /// @param to_head  the request was HEAD: no payload
  /// @param caller  on whose behalf a spooled payload is read
  boost::asio::awaitable<bool> Send(const HttpResponse& response,
                                    bool to_head,
                                    bool keep_alive,
                                    const std::string& caller);
  /// Answers and ends the connection without a reset: for a while it discards what the client still
  /// sends, because a reset would delete the answer before the client has read it.
  boost::asio::awaitable<void> Refuse(HttpResponse response, bool to_head);

  /// While it exists, `still_may` is called every `look_every`, on the pool, for `caller`; when it
  /// returns false, the connection is cut. An empty function is not called.
  class Watch {
   public:
    Watch(PacedSender& sender, const std::string& caller, std::function<bool()> still_may);
    ~Watch() { sender_.still_may_ = {}; }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

   private:
    PacedSender& sender_;
  };
  /// Requests the check when it is due. Called from the code that checks the clock, between two
  /// steps of this sender.
  void LookIfDue();

 private:
  boost::asio::awaitable<bool> CutWhenItMayNot();
  boost::asio::awaitable<bool> SendSpool(const Spool& spool, const std::string& caller);
  void Deadline(std::chrono::milliseconds from_now) { deadline_ = host_.now + from_now; }

  ConnectionHost& host_;
  boost::asio::ip::tcp::socket& socket_;
  std::chrono::steady_clock::time_point& deadline_;
  std::function<bool()> still_may_;
  std::string asks_for_;  ///< the caller, while a check is set
  std::chrono::steady_clock::time_point look_at_{};
  bool look_due_ = false;
};

/// Time for a refused or closing client to leave.
inline constexpr std::chrono::milliseconds kLinger{2000};

}  // namespace faultlab::server
