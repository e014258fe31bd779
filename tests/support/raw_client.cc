#include "tests/support/raw_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <stdexcept>

namespace faultlab::tests {
namespace {

constexpr int kPatienceSeconds = 120;  // a guard against hanging

bool SameWord(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

}  // namespace

std::string HttpAnswer::Header(std::string_view name) const {
  for (const auto& [key, value] : headers) {
    if (SameWord(key, name)) return value;
  }
  return {};
}

RawClient::RawClient(int port, int receive_buffer_bytes) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
  timeval patience{};
  patience.tv_sec = kPatienceSeconds;
  setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  if (receive_buffer_bytes > 0) {
    setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
  }
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("cannot connect");
  }
}

RawClient::~RawClient() {
  close(fd_);
}

bool RawClient::Send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

void RawClient::ShutdownWrite() {
  shutdown(fd_, SHUT_WR);
}

bool RawClient::Fill() {
  std::array<char, 16384> bytes;
  const ssize_t got = recv(fd_, bytes.data(), bytes.size(), 0);
  if (got <= 0) return false;
  buffer_.append(bytes.data(), static_cast<std::size_t>(got));
  return true;
}

HttpAnswer RawClient::ReadAnswer(bool head) {
  HttpAnswer answer;
  std::size_t end = 0;
  while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
    if (!Fill()) return answer;
  }
  const std::string text = buffer_.substr(0, end + 2);
  buffer_.erase(0, end + 4);
  answer.status = std::atoi(text.c_str() + std::string_view("HTTP/1.1 ").size());
  std::size_t at = text.find("\r\n") + 2;
  while (at < text.size()) {
    const std::size_t stop = text.find("\r\n", at);
    const std::size_t colon = text.find(": ", at);
    answer.headers.emplace_back(text.substr(at, colon - at),
                                text.substr(colon + 2, stop - colon - 2));
    at = stop + 2;
  }
  const std::string length = answer.Header("Content-Length");
  if (head || length.empty()) return answer;
  const std::size_t size = std::strtoull(length.c_str(), nullptr, 10);
  while (buffer_.size() < size) {
    if (!Fill()) break;
  }
  answer.body = buffer_.substr(0, size);
  buffer_.erase(0, size);
  return answer;
}

std::string RawClient::ReadAll() {
  while (Fill()) {
  }
  return std::exchange(buffer_, {});
}

bool RawClient::WaitForClose() {
  std::array<char, 65536> waste;
  for (;;) {
    const ssize_t got = recv(fd_, waste.data(), waste.size(), 0);
    if (got == 0) return true;
    if (got < 0) return errno == ECONNRESET;
  }
}

HttpAnswer Request(int port,
                   const std::string& method,
                   const std::string& target,
                   const std::string& extra_headers,
                   const std::string& body) {
  RawClient client(port);
  std::string request = method + " " + target + " HTTP/1.1\r\nHost: localhost\r\n" + extra_headers;
  if (!body.empty() || method == "POST") {
    request += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  }
  client.Send(request + "Connection: close\r\n\r\n" + body);
  return client.ReadAnswer(method == "HEAD");
}

HttpAnswer Get(int port, const std::string& target, const std::string& extra_headers) {
  return Request(port, "GET", target, extra_headers);
}

HttpAnswer Post(int port,
                const std::string& target,
                const std::string& body,
                const std::string& content_type) {
  return Request(port, "POST", target, "Content-Type: " + content_type + "\r\n", body);
}

int WebSocketClient::Frame::close_code() const {
  if (opcode != 8 || payload.size() < 2) return 0;
  return (static_cast<unsigned char>(payload[0]) << 8) | static_cast<unsigned char>(payload[1]);
}

std::string ClientFrame(int first_byte, std::string_view payload, bool masked) {
  std::string frame(1, static_cast<char>(first_byte));
  const char mask_bit = masked ? static_cast<char>(0x80) : '\0';
  const std::size_t size = payload.size();
  if (size < 126) {
    frame.push_back(static_cast<char>(mask_bit | static_cast<char>(size)));
  } else {
    const int bytes = size <= 0xFFFF ? 2 : 8;
    frame.push_back(static_cast<char>(mask_bit | static_cast<char>(bytes == 2 ? 126 : 127)));
    for (int i = bytes - 1; i >= 0; --i) frame.push_back(static_cast<char>(size >> (8 * i)));
  }
  constexpr std::string_view kMask = "\x12\x34\x56\x78";
  if (masked) frame.append(kMask);
  for (std::size_t i = 0; i < size; ++i) {
    frame.push_back(masked ? static_cast<char>(payload[i] ^ kMask[i % 4]) : payload[i]);
  }
  return frame;
}

WebSocketClient::WebSocketClient(int port, const std::string& target, int receive_buffer_bytes)
    : RawClient(port, receive_buffer_bytes) {
  Send("GET " + target +
       " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
       "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  status_ = ReadAnswer().status;
}

bool WebSocketClient::SendFrame(int first_byte, std::string_view payload, bool masked) {
  return Send(ClientFrame(first_byte, payload, masked));
}

std::optional<WebSocketClient::Frame> WebSocketClient::Read() {
  for (;;) {
    while (buffer_.size() < 2) {
      if (!Fill()) return std::nullopt;
    }
    const auto at = [this](std::size_t i) { return static_cast<unsigned char>(buffer_[i]); };
    std::size_t header = 2;
    std::uint64_t size = at(1) & 0x7F;
    const std::size_t length_bytes = size == 126 ? 2 : size == 127 ? 8 : 0;
    header += length_bytes;
    while (buffer_.size() < header) {
      if (!Fill()) return std::nullopt;
    }
    if (length_bytes > 0) size = 0;
    for (std::size_t i = 0; i < length_bytes; ++i) size = (size << 8) | at(2 + i);
    while (buffer_.size() < header + size) {
      if (!Fill()) return std::nullopt;
    }
    Frame frame{at(0) & 0x0F, buffer_.substr(header, size)};
    buffer_.erase(0, header + size);
    if (frame.opcode != 9) return frame;
    SendFrame(0x8A, frame.payload);
    ++pings_answered_;
  }
}

std::optional<std::string> WebSocketClient::ReadTextWith(std::string_view part) {
  while (auto frame = Read()) {
    if (frame->opcode == 1 && frame->payload.find(part) != std::string::npos) {
      return frame->payload;
    }
  }
  return std::nullopt;
}

}  // namespace faultlab::tests
