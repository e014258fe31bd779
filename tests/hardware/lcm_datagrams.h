#pragma once

// LCM's datagrams as another program may send them, with any numbers.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hardware/lcm/lcm_packet.h"

namespace faultlab::hardware {

using Datagram = std::vector<std::uint8_t>;

inline void PutBigEndian(Datagram& out, std::uint32_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

inline Datagram ShortDatagram(std::uint32_t sequence, std::string_view body) {
  Datagram out = {'L', 'C', '0', '2'};
  PutBigEndian(out, sequence, 4);
  out.insert(out.end(), body.begin(), body.end());
  return out;
}

struct FragmentHead {
  std::uint32_t sequence = 0;
  std::uint32_t size = 0;
  std::uint32_t offset = 0;
  std::uint16_t number = 0;
  std::uint16_t count = 0;
};

inline Datagram FragmentDatagram(const FragmentHead& head, std::string_view body) {
  Datagram out = {'L', 'C', '0', '3'};
  PutBigEndian(out, head.sequence, 4);
  PutBigEndian(out, head.size, 4);
  PutBigEndian(out, head.offset, 4);
  PutBigEndian(out, head.number, 2);
  PutBigEndian(out, head.count, 2);
  out.insert(out.end(), body.begin(), body.end());
  return out;
}

/// For a channel: fragments with wrong numbers in every place. The first one crashes liblcm 1.3.1.
inline std::vector<Datagram> BadDatagrams(const std::string& channel) {
  constexpr std::uint32_t kOdd[] = {0, 1, 3000, 0x7fffffff, 0x80000000, 0xfffffff0, 0xffffffff};
  constexpr std::uint16_t kNumbers[] = {0, 1, 2, 0xffff};
  const std::string tail(100, 'x');
  const std::string body = channel + std::string(1, '\0') + tail;
  std::uint32_t sequence = 0;
  const auto next = [&](FragmentHead head) {
    head.sequence = sequence++;
    return head;
  };
  std::vector<Datagram> bad = {
      // In 32 bits offset + size is 99.
      FragmentDatagram(next({.size = 3000, .offset = 0xffffffff, .count = 2}), body),
      FragmentDatagram(next({.size = 10, .count = 2}), ""),
      FragmentDatagram(next({.size = 10, .count = 2}), "A"),
      ShortDatagram(sequence++, channel)};  // the channel does not end
  // A correct one, followed by the same again.
  FragmentHead head = next({.size = 3000, .count = 2});
  bad.push_back(FragmentDatagram(head, body));
  head.number = 1;
  head.offset = 0xfffffff0;
  bad.push_back(FragmentDatagram(head, tail));
  for (const std::uint32_t size : kOdd) {
    for (const std::uint32_t offset : kOdd) {
      for (const std::uint16_t count : kNumbers) {
        ++sequence;
        for (const std::uint16_t number : kNumbers) {
          head = {.sequence = sequence,
                  .size = size,
                  .offset = offset,
                  .number = number,
                  .count = count};
          bad.push_back(FragmentDatagram(head, number == 0 ? body : tail));
        }
      }
    }
  }
  return bad;
}

/// A message as its sender encodes it.
inline std::vector<Datagram> DatagramsOf(std::uint32_t sequence,
                                         std::string_view channel,
                                         std::span<const std::uint8_t> message) {
  std::vector<Datagram> datagrams;
  (void)WriteLcmPackets(sequence, channel, message, [&](auto head, auto payload) {
    Datagram datagram(head.begin(), head.end());
    datagram.insert(datagram.end(), payload.begin(), payload.end());
    datagrams.push_back(std::move(datagram));
  });
  return datagrams;
}

/// Bytes of which no two neighbouring pieces are equal.
inline std::vector<std::uint8_t> SomeBytes(std::size_t size, std::uint32_t seed = 1) {
  std::vector<std::uint8_t> bytes(size);
  std::uint32_t state = seed;
  for (std::uint8_t& byte : bytes) {
    state = state * 1664525u + 1013904223u;
    byte = static_cast<std::uint8_t>(state >> 24);
  }
  return bytes;
}

}  // namespace faultlab::hardware
