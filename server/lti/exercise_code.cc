#include "server/lti/exercise_code.h"

#include <sodium.h>

#include <array>
#include <charconv>

#include "server/oidc/base64url.h"

namespace faultlab::server::lti {

std::string ExerciseCode(std::int64_t assignment, std::string_view secret) {
  const std::string text = "faultlab exercise " + std::to_string(assignment) + " ";
  crypto_generichash_state state;
  std::array<unsigned char, 16> seal{};
  crypto_generichash_init(&state, nullptr, 0, seal.size());
  for (const std::string_view part : {std::string_view(text), secret}) {
    crypto_generichash_update(
        &state, reinterpret_cast<const unsigned char*>(part.data()), part.size());
  }
  crypto_generichash_final(&state, seal.data(), seal.size());
  return std::to_string(assignment) + "-" +
         oidc::EncodeBase64Url({reinterpret_cast<const char*>(seal.data()), seal.size()});
}

std::optional<std::int64_t> ExerciseOf(std::string_view code, std::string_view secret) {
  std::int64_t assignment = 0;
  std::from_chars(code.data(), code.data() + code.size(), assignment);
  const std::string right = ExerciseCode(assignment, secret);
  const bool same =
      code.size() == right.size() && sodium_memcmp(code.data(), right.data(), right.size()) == 0;
  return same ? std::optional(assignment) : std::nullopt;
}

}  // namespace faultlab::server::lti
