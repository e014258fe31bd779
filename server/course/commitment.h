#pragma once

#include <string>
#include <string_view>

namespace faultlab::server::course {

/// What a student gets before a trial, so that nobody can change its truth afterwards.
///   commitment = SHA-256(nonce || truth) in hex
/// `printf '%s%s' NONCE TRUTH | sha256sum` checks it once both are released.
struct Commitment {
  std::string nonce;  ///< 43 random characters: short truths could be tried out
  std::string hash;   ///< 64 hex digits
};

Commitment CommitTo(std::string_view truth);
std::string CommitmentOf(std::string_view nonce, std::string_view truth);

}  // namespace faultlab::server::course
