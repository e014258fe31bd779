#include "server/notify/signature.h"

#include <sodium.h>

#include <array>
#include <vector>

#include "core/types/check.h"

namespace faultlab::server::notify {
namespace {

constexpr std::string_view kPrefix = "whsec_";
constexpr std::size_t kSecretBytes = 32;

std::string Base64(const unsigned char* bytes, std::size_t size) {
  std::string out(sodium_base64_encoded_len(size, sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(out.data(), out.size(), bytes, size, sodium_base64_VARIANT_ORIGINAL);
  out.pop_back();  // the terminating zero
  return out;
}

const unsigned char* BytesOf(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

}  // namespace

std::string NewHookSecret() {
  LAB_CHECK(sodium_init() >= 0);
  std::array<unsigned char, kSecretBytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return std::string(kPrefix) + Base64(bytes.data(), bytes.size());
}

std::string Sign(std::string_view secret,
                 std::string_view id,
                 std::string_view seconds,
                 std::string_view body) {
  LAB_CHECK(sodium_init() >= 0);
  const std::string_view text = secret.starts_with(kPrefix) ? secret.substr(kPrefix.size()) : "";
  std::vector<unsigned char> key(text.size());
  std::size_t bytes = 0;
  const int read = sodium_base642bin(key.data(),
                                     key.size(),
                                     text.data(),
                                     text.size(),
                                     nullptr,
                                     &bytes,
                                     nullptr,
                                     sodium_base64_VARIANT_ORIGINAL);
  LAB_CHECK(read == 0);
  crypto_auth_hmacsha256_state state{};
  crypto_auth_hmacsha256_init(&state, key.data(), bytes);
  const std::string head = std::string(id) + "." + std::string(seconds) + ".";
  crypto_auth_hmacsha256_update(&state, BytesOf(head), head.size());
  crypto_auth_hmacsha256_update(&state, BytesOf(body), body.size());
  std::array<unsigned char, crypto_auth_hmacsha256_BYTES> mac{};
  crypto_auth_hmacsha256_final(&state, mac.data());
  return "v1," + Base64(mac.data(), mac.size());
}

}  // namespace faultlab::server::notify
