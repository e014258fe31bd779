#include "server/auth/secrets.h"

#include <sodium.h>

#include <array>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kSecretBytes = 32;

void StartSodium() {
  static const int started = sodium_init();
  LAB_CHECK(started >= 0);
}

core::Error Busy() {
  return core::Refuse("sign_ins_full");
}

}  // namespace

std::string NewSecret(std::string_view prefix) {
  StartSodium();
  std::array<unsigned char, kSecretBytes> random;
  randombytes_buf(random.data(), random.size());
  std::array<char,
             sodium_base64_ENCODED_LEN(kSecretBytes, sodium_base64_VARIANT_URLSAFE_NO_PADDING)>
      text;
  sodium_bin2base64(text.data(),
                    text.size(),
                    random.data(),
                    random.size(),
                    sodium_base64_VARIANT_URLSAFE_NO_PADDING);
  return std::string(prefix) + text.data();
}

std::uint64_t SecretNumber() {
  StartSodium();
  std::uint64_t number = 0;
  randombytes_buf(&number, sizeof number);
  return number >> 11;
}

std::string HashSecret(std::string_view secret) {
  StartSodium();
  std::array<unsigned char, kSecretBytes> hash;
  crypto_generichash(hash.data(),
                     hash.size(),
                     reinterpret_cast<const unsigned char*>(secret.data()),
                     secret.size(),
                     nullptr,
                     0);
  std::array<char, 2 * kSecretBytes + 1> text;
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  return text.data();
}

bool SameSecret(std::string_view a, std::string_view b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

/// One of the places for computing a hash.
class PasswordHasher::Turn {
 public:
  explicit Turn(PasswordHasher& hasher) : hasher_(hasher) {
    std::unique_lock lock(hasher_.mutex_);
    taken_ = hasher_.freed_.wait_for(
        lock, hasher_.patience_, [&] { return hasher_.running_ < hasher_.parallel_max_; });
    if (taken_) ++hasher_.running_;
  }
  ~Turn() {
    if (!taken_) return;
    {
      const std::lock_guard lock(hasher_.mutex_);
      --hasher_.running_;
    }
    hasher_.freed_.notify_one();
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  bool taken() const { return taken_; }

 private:
  PasswordHasher& hasher_;
  bool taken_ = false;
};

PasswordHasher::PasswordHasher(PasswordCost cost,
                               int parallel_max,
                               std::chrono::milliseconds patience)
    : cost_(cost), parallel_max_(parallel_max), patience_(patience) {
  StartSodium();
}

core::Result<std::string> PasswordHasher::Hash(std::string_view password) {
  const Turn turn(*this);
  if (!turn.taken()) return Busy();
  const bool least = cost_ == PasswordCost::kLeast;
  std::array<char, crypto_pwhash_STRBYTES> text;
  const int failed =
      crypto_pwhash_str_alg(text.data(),
                            password.data(),
                            password.size(),
                            least ? crypto_pwhash_OPSLIMIT_MIN : crypto_pwhash_OPSLIMIT_INTERACTIVE,
                            least ? crypto_pwhash_MEMLIMIT_MIN : crypto_pwhash_MEMLIMIT_INTERACTIVE,
                            crypto_pwhash_ALG_ARGON2ID13);
  if (failed != 0) return Busy();  // it can fail only for lack of memory
  return std::string(text.data());
}

core::Result<bool> PasswordHasher::Verify(const std::string& hash, std::string_view password) {
  if (hash.empty()) {
    TRY_DONE(Hash(password));
    return false;
  }
  const Turn turn(*this);
  if (!turn.taken()) return Busy();
  return crypto_pwhash_str_verify(hash.c_str(), password.data(), password.size()) == 0;
}

}  // namespace faultlab::server
