#include "server/oidc/login_state.h"

#include <openssl/evp.h>
#include <openssl/sha.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <boost/json.hpp>

#include "core/types/check.h"
#include "server/oidc/base64url.h"
#include "server/oidc/claims.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;

constexpr std::size_t kSealedMax = 4096;
constexpr std::size_t kPathMax = 500;
constexpr auto kSkew = std::chrono::minutes(1);

unsigned char* Raw(std::string& text) {
  return reinterpret_cast<unsigned char*>(text.data());
}
const unsigned char* Raw(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

}  // namespace

LoginSeal::LoginSeal(std::string_view secret) : key_(crypto_secretbox_KEYBYTES, '\0') {
  LAB_CHECK(sodium_init() >= 0);
  const std::string text = "faultlab login state " + std::string(secret);
  crypto_generichash(Raw(key_), key_.size(), Raw(text), text.size(), nullptr, 0);
}

std::string LoginSeal::Close(const LoginState& state) const {
  const std::string text = json::serialize(json::object{{"provider", state.provider},
                                                        {"state", state.state},
                                                        {"nonce", state.nonce},
                                                        {"verifier", state.verifier},
                                                        {"redirect_uri", state.redirect_uri},
                                                        {"next", state.next},
                                                        {"add_to", state.add_to},
                                                        {"began", ToMilliseconds(state.began)}});
  std::string nonce(crypto_secretbox_NONCEBYTES, '\0');
  randombytes_buf(nonce.data(), nonce.size());
  std::string box(crypto_secretbox_MACBYTES + text.size(), '\0');
  crypto_secretbox_easy(Raw(box), Raw(text), text.size(), Raw(nonce), Raw(key_));
  return EncodeBase64Url(nonce + box);
}

std::optional<LoginState> LoginSeal::Open(std::string_view text,
                                          WallTime now,
                                          std::chrono::minutes lives) const {
  if (text.size() > kSealedMax) return std::nullopt;
  const auto sealed = DecodeBase64Url(text);
  constexpr std::size_t kAround = crypto_secretbox_NONCEBYTES + crypto_secretbox_MACBYTES;
  if (!sealed || sealed->size() < kAround) return std::nullopt;
  const std::string nonce = sealed->substr(0, crypto_secretbox_NONCEBYTES);
  const std::string box = sealed->substr(crypto_secretbox_NONCEBYTES);
  std::string opened(box.size() - crypto_secretbox_MACBYTES, '\0');
  if (crypto_secretbox_open_easy(Raw(opened), Raw(box), box.size(), Raw(nonce), Raw(key_)) != 0) {
    return std::nullopt;
  }
  const json::value value = json::parse(opened);  // sealed, so it is valid
  const json::object& in = value.as_object();
  LoginState out;
  out.provider = TextOf(in, "provider");
  out.state = TextOf(in, "state");
  out.nonce = TextOf(in, "nonce");
  out.verifier = TextOf(in, "verifier");
  out.redirect_uri = TextOf(in, "redirect_uri");
  out.next = TextOf(in, "next");
  out.add_to = in.at("add_to").as_int64();
  out.began = FromMilliseconds(in.at("began").as_int64());
  if (now >= out.began + lives || now < out.began - kSkew) return std::nullopt;
  return out;
}

std::string RandomText() {
  LAB_CHECK(sodium_init() >= 0);
  std::string bytes(32, '\0');
  randombytes_buf(bytes.data(), bytes.size());
  return EncodeBase64Url(bytes);
}

std::string ChallengeOf(std::string_view verifier) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
  EVP_Digest(verifier.data(), verifier.size(), hash.data(), nullptr, EVP_sha256(), nullptr);
  return EncodeBase64Url({reinterpret_cast<const char*>(hash.data()), hash.size()});
}

std::string PathHere(std::string_view text) {
  // A browser treats "//evil.example" and "/\evil.example" as addresses of other hosts, and it
  // first removes tabs and line ends.
  const bool path = !text.empty() && text.size() <= kPathMax && text[0] == '/' &&
                    (text.size() == 1 || (text[1] != '/' && text[1] != '\\'));
  const bool plain = std::ranges::all_of(
      text, [](char c) { return c > ' ' && c < 0x7f && c != '\\' && c != '"'; });
  return path && plain ? std::string(text) : "/my";
}

}  // namespace faultlab::server::oidc
