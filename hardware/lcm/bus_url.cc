#include "hardware/lcm/bus_url.h"

#include <arpa/inet.h>

#include <charconv>
#include <limits>
#include <optional>
#include <string_view>

namespace faultlab::hardware {
namespace {

constexpr std::string_view kUdpm = "udpm://";
constexpr std::string_view kOtherBuses[] = {"memq://", "file://"};
constexpr in_addr_t kDefaultGroup = 0xefff4c43;  // 239.255.76.67

core::Error Invalid(const std::string& url, const std::string& why) {
  return {.code = core::ErrorCode::kInvalid,
          .message = "the LCM bus " + url + ": " + why,
          .field = "lcm"};
}

std::optional<int> NumberWithin(std::string_view text, int min, int max) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (value < min || value > max) return std::nullopt;
  return value;
}

/// Cuts `text` at the first `mark`; returns what was before it.
std::string_view TakeUntil(std::string_view& text, char mark) {
  const std::size_t at = text.find(mark);
  const std::string_view head = text.substr(0, at);
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + 1);
  return head;
}

}  // namespace

core::Result<UdpmUrl> ParseUdpmUrl(const std::string& url) {
  UdpmUrl parsed;
  parsed.group.s_addr = htonl(kDefaultGroup);
  std::string_view options = url;
  if (!options.starts_with(kUdpm)) return Invalid(url, "it does not begin with udpm://");
  options.remove_prefix(kUdpm.size());
  std::string_view port = TakeUntil(options, '?');
  const std::string group(TakeUntil(port, ':'));
  if (!group.empty() && (inet_pton(AF_INET, group.c_str(), &parsed.group) != 1 ||
                         !IN_MULTICAST(ntohl(parsed.group.s_addr)))) {
    return Invalid(url, group + " is not a multicast address, 224.0.0.0 to 239.255.255.255");
  }
  if (!port.empty()) {
    const auto number = NumberWithin(port, 1, std::numeric_limits<std::uint16_t>::max());
    if (!number) return Invalid(url, "the port is a number from 1 to 65535");
    parsed.port = static_cast<std::uint16_t>(*number);
  }
  while (!options.empty()) {
    std::string_view value = TakeUntil(options, '&');
    const std::string name(TakeUntil(value, '='));
    if (name == "ttl") {
      const auto number = NumberWithin(value, 0, 255);
      if (!number) return Invalid(url, "ttl is a number from 0 to 255");
      parsed.ttl = *number;
    } else if (name == "recv_buf_size") {
      const auto number = NumberWithin(value, 1, std::numeric_limits<int>::max());
      if (!number) return Invalid(url, "recv_buf_size is a number of bytes");
      parsed.receive_bytes = *number;
    } else {
      return Invalid(url, "its options are ttl and recv_buf_size, not \"" + name + "\"");
    }
  }
  return parsed;
}

core::Status CheckBusUrl(const std::string& url) {
  for (const std::string_view bus : kOtherBuses) {
    if (url.starts_with(bus)) return core::Done();
  }
  if (!url.starts_with(kUdpm)) {
    return Invalid(url, "a bus is udpm://GROUP:PORT?ttl=HOPS (UDP multicast), memq:// or file://");
  }
  TRY_DONE(ParseUdpmUrl(url));
  return core::Done();
}

core::Error BusDoesNotOpen(const std::string& url, const std::string& why) {
  return {.code = core::ErrorCode::kUnavailable,
          .message = "the LCM bus " + url + " does not open" +
                     (why.empty() ? "" : " (" + why + ")") +
                     "; udpm needs a multicast route (on one machine: ip link set lo multicast on; "
                     "ip route add 239.255.76.67/32 dev lo)",
          .field = "lcm"};
}

}  // namespace faultlab::hardware
