#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>

#include "core/types/result.h"

namespace faultlab::hardware {

/// A bus on UDP multicast: udpm://GROUP:PORT?ttl=HOPS&recv_buf_size=BYTES, every part optional.
struct UdpmUrl {
  in_addr group{};  ///< 239.255.76.67, LCM's own
  std::uint16_t port = 7667;
  int ttl = 0;                    ///< 0: this machine, 1: this network
  int receive_bytes = 4'000'000;  ///< of the kernel; its default loses bursts silently
};

/// kInvalid, naming the part, for anything that is not such a URL.
core::Result<UdpmUrl> ParseUdpmUrl(const std::string& url);

/// The buses that we open: udpm://, memq:// and file://. kInvalid for the rest: in tcpq:// and
/// mpudpm:// liblcm reads the network itself and believes the lengths that it finds there.
core::Status CheckBusUrl(const std::string& url);

/// kUnavailable, with what to do.
core::Error BusDoesNotOpen(const std::string& url, const std::string& why);

}  // namespace faultlab::hardware
