#include "server/course/commitment.h"

#include <sodium.h>

#include <array>

#include "server/auth/secrets.h"

namespace faultlab::server::course {

std::string CommitmentOf(std::string_view nonce, std::string_view truth) {
  const std::string text = std::string(nonce) + std::string(truth);
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash;
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(text.data()), text.size());
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> hex;
  sodium_bin2hex(hex.data(), hex.size(), hash.data(), hash.size());
  return hex.data();
}

Commitment CommitTo(std::string_view truth) {
  Commitment made{NewSecret(""), ""};
  made.hash = CommitmentOf(made.nonce, truth);
  return made;
}

}  // namespace faultlab::server::course
