#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace faultlab::tests {

struct HttpAnswer {
  int status = 0;  ///< 0: the connection ended without an answer
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;

  std::string Header(std::string_view name) const;  ///< any case; empty if absent
};

/// A blocking socket to 127.0.0.1 that sends exactly the given bytes. Reads give up after 20 s, so
/// that a test fails instead of hanging.
class RawClient {
 public:
  explicit RawClient(int port, int receive_buffer_bytes = 0);
  ~RawClient();
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// False when the peer has closed.
  bool Send(std::string_view bytes);
  void ShutdownWrite();
  /// One answer with its body, by Content-Length; `head` for answers to HEAD.
  HttpAnswer ReadAnswer(bool head = false);
  /// Everything that comes until the peer closes.
  std::string ReadAll();
  /// True once the peer has closed; discards what comes before.
  bool WaitForClose();
  int fd() const { return fd_; }

 protected:
  bool Fill();  ///< more bytes into buffer_; false at the end
  std::string buffer_;

 private:
  int fd_;
};

/// GET or POST on a connection of its own.
HttpAnswer Get(int port, const std::string& target, const std::string& extra_headers = {});
HttpAnswer Post(int port,
                const std::string& target,
                const std::string& body,
                const std::string& content_type = "application/json");
HttpAnswer Request(int port,
                   const std::string& method,
                   const std::string& target,
                   const std::string& extra_headers = {},
                   const std::string& body = {});

/// A WebSocket client that can also violate the protocol.
class WebSocketClient : public RawClient {
 public:
  struct Frame {
    int opcode = 0;  ///< 1 text, 2 binary, 8 close, 9 ping, 10 pong
    std::string payload;
    /// The code of a close frame; 0 for other frames.
    int close_code() const;
  };

  /// Connects and makes the handshake; status() is its result.
  WebSocketClient(int port, const std::string& target, int receive_buffer_bytes = 0);

  int status() const { return status_; }
  int pings_answered() const { return pings_answered_; }
  bool SendText(std::string_view text) { return SendFrame(0x81, text); }
  bool SendFrame(int first_byte, std::string_view payload, bool masked = true);
  /// nullopt when the peer has closed. Pings are answered automatically.
  std::optional<Frame> Read();
  /// The next text message that contains `part`; others are skipped.
  std::optional<std::string> ReadTextWith(std::string_view part);

 private:
  int status_ = 0;
  int pings_answered_ = 0;
};

/// A masked client frame.
std::string ClientFrame(int first_byte, std::string_view payload, bool masked = true);

}  // namespace faultlab::tests
