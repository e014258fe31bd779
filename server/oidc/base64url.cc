#include "server/oidc/base64url.h"

#include <sodium.h>

namespace faultlab::server::oidc {

constexpr int kVariant = sodium_base64_VARIANT_URLSAFE_NO_PADDING;

std::optional<std::string> DecodeBase64Url(std::string_view text) {
  std::string out(text.size(), '\0');
  std::size_t size = 0;
  const int failed = sodium_base642bin(reinterpret_cast<unsigned char*>(out.data()),
                                       out.size(),
                                       text.data(),
                                       text.size(),
                                       nullptr,
                                       &size,
                                       nullptr,
                                       kVariant);
  if (failed != 0) return std::nullopt;
  out.resize(size);
  return out;
}

std::string EncodeBase64Url(std::string_view bytes) {
  std::string out(sodium_base64_encoded_len(bytes.size(), kVariant), '\0');
  sodium_bin2base64(out.data(),
                    out.size(),
                    reinterpret_cast<const unsigned char*>(bytes.data()),
                    bytes.size(),
                    kVariant);
  out.pop_back();  // the terminating zero
  return out;
}

}  // namespace faultlab::server::oidc
