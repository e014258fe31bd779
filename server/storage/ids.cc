#include "server/storage/ids.h"

#include <sys/random.h>

#include <array>

#include "core/types/check.h"

namespace faultlab::server {
namespace {
constexpr std::string_view kAlphabet = "0123456789abcdefghijklmnopqrstuvwxyz";
constexpr int kLength = 20;
constexpr unsigned char kFairBelow = 252;  // 7 * 36; larger bytes would bias the letters
}  // namespace

std::string NewId(std::string_view prefix) {
  std::string id(prefix);
  id += '-';
  const std::size_t length = id.size() + kLength;
  while (id.size() < length) {
    std::array<unsigned char, kLength> random;
    const ssize_t got = getrandom(random.data(), random.size(), 0);
    LAB_CHECK(got == static_cast<ssize_t>(random.size()));
    for (const unsigned char byte : random) {
      if (byte < kFairBelow && id.size() < length) id += kAlphabet[byte % kAlphabet.size()];
    }
  }
  return id;
}

}  // namespace faultlab::server
