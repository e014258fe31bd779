#include "server/mail/letter.h"

#include <date/date.h>
#include <sodium.h>

#include <algorithm>
#include <chrono>

namespace faultlab::server::mail {
namespace {

std::string Base64(std::string_view text) {
  constexpr int kVariant = sodium_base64_VARIANT_ORIGINAL;
  std::string out(sodium_base64_encoded_len(text.size(), kVariant), '\0');
  sodium_bin2base64(out.data(),
                    out.size(),
                    reinterpret_cast<const unsigned char*>(text.data()),
                    text.size(),
                    kVariant);
  out.pop_back();  // its zero
  return out;
}

std::string EncodedWords(std::string_view utf8) {
  constexpr std::size_t kBytes = 42;  // 56 letters of base64, and 12 around them
  std::string out;
  while (!utf8.empty()) {
    std::size_t size = std::min(kBytes, utf8.size());
    while (size < utf8.size() && size > 1 && (utf8[size] & '\xC0') == '\x80') --size;
    out += (out.empty() ? "=?UTF-8?B?" : " =?UTF-8?B?") + Base64(utf8.substr(0, size)) + "?=";
    utf8.remove_prefix(size);
  }
  return out;
}

}  // namespace

bool IsAddress(std::string_view text) {
  constexpr std::size_t kBytesMax = 254;
  constexpr std::string_view kNever = " \"(),:;<>[]\\";
  const std::size_t at = text.find('@');
  const bool printable = std::ranges::all_of(text, [](char c) { return c > ' ' && c < '\x7f'; }) &&
                         text.find_first_of(kNever) == std::string_view::npos;
  return printable && text.size() <= kBytesMax && at != 0 && at != std::string_view::npos &&
         at + 1 < text.size() && text.find('@', at + 1) == std::string_view::npos &&
         !text.starts_with('-');
}

std::string HeaderText(std::string_view utf8) {
  const auto plain = [](char c) { return c >= ' ' && c < '\x7f'; };
  const bool ascii = std::ranges::all_of(utf8, plain) && utf8.find("=?") == std::string_view::npos;
  return ascii ? std::string(utf8) : EncodedWords(utf8);
}

std::string NameText(std::string_view utf8) {
  const auto plain = [](char c) {
    return c == ' ' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
  };
  return std::ranges::all_of(utf8, plain) ? std::string(utf8) : EncodedWords(utf8);
}

std::string DateText(WallTime time) {
  return date::format("%a, %d %b %Y %T +0000", std::chrono::floor<std::chrono::seconds>(time));
}

}  // namespace faultlab::server::mail
