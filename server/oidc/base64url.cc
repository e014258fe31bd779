#include "server/oidc/base64url.h"

#include <cstdint>

namespace faultlab::server::oidc {
namespace {

constexpr std::string_view kAlphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
constexpr unsigned kBitsOfLetter = 6;
constexpr unsigned kBitsOfByte = 8;

}  // namespace

std::optional<std::string> DecodeBase64Url(std::string_view text) {
  if (text.size() % 4 == 1) return std::nullopt;
  std::string out;
  out.reserve(text.size() * 3 / 4);
  std::uint32_t bits = 0;
  unsigned count = 0;
  for (const char c : text) {
    const std::size_t value = kAlphabet.find(c);
    if (value == std::string_view::npos) return std::nullopt;
    bits = (bits << kBitsOfLetter) | static_cast<std::uint32_t>(value);
    count += kBitsOfLetter;
    if (count < kBitsOfByte) continue;
    count -= kBitsOfByte;
    out.push_back(static_cast<char>((bits >> count) & 0xffU));
  }
  const std::uint32_t rest = bits & ((1U << count) - 1U);
  if (rest != 0) return std::nullopt;
  return out;
}

std::string EncodeBase64Url(std::string_view bytes) {
  std::string out;
  out.reserve((bytes.size() * 4 + 2) / 3);
  std::uint32_t bits = 0;
  unsigned count = 0;
  for (const char c : bytes) {
    bits = (bits << kBitsOfByte) | static_cast<unsigned char>(c);
    count += kBitsOfByte;
    while (count >= kBitsOfLetter) {
      count -= kBitsOfLetter;
      out.push_back(kAlphabet[(bits >> count) & 0x3fU]);
    }
  }
  if (count > 0) out.push_back(kAlphabet[(bits << (kBitsOfLetter - count)) & 0x3fU]);
  return out;
}

}  // namespace faultlab::server::oidc
