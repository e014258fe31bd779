#include "core/types/utf8.h"

#include <array>

namespace faultlab::core {
namespace {

constexpr Utf8Character kBroken{.code = 0xFFFD, .bytes = 1, .valid = false};

bool Continues(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

}  // namespace

Utf8Character FirstCharacter(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  if (lead < 0x80) return {.code = lead};
  const std::size_t bytes = lead < 0xC0   ? 0
                            : lead < 0xE0 ? 2
                            : lead < 0xF0 ? 3
                            : lead < 0xF8 ? 4
                                          : 0;
  if (bytes == 0 || bytes > text.size()) return kBroken;
  char32_t code = lead & (0xFFU >> (bytes + 1));
  for (const char next : text.substr(1, bytes - 1)) {
    if (!Continues(next)) return kBroken;
    code = (code << 6U) | (static_cast<unsigned char>(next) & 0x3FU);
  }
  constexpr std::array<char32_t, 5> kSmallest = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < kSmallest[bytes] || code > 0x10FFFF || surrogate) return kBroken;
  return {.code = code, .bytes = bytes};
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const Utf8Character first = FirstCharacter(text);
    if (!first.valid) return false;
    text.remove_prefix(first.bytes);
  }
  return true;
}

std::string_view CutUtf8(std::string_view text, std::size_t bytes_max) {
  if (text.size() <= bytes_max) return text;
  while (bytes_max > 0 && Continues(text[bytes_max])) --bytes_max;
  return text.substr(0, bytes_max);
}

void AppendUtf8(std::string& text, char32_t code) {
  if (code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) code = 0xFFFD;
  const std::size_t more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
  constexpr std::array<unsigned, 4> kLead = {0, 0xC0, 0xE0, 0xF0};
  text += static_cast<char>(kLead[more] | (code >> (6 * more)));
  for (std::size_t left = more; left > 0; --left) {
    text += static_cast<char>(0x80U | ((code >> (6 * (left - 1))) & 0x3FU));
  }
}

std::string FromWindows1252(std::string_view bytes) {
  constexpr std::array<char16_t, 32> kFrom0x80 = {
      0x20AC, 0x81,   0x201A, 0x192,  0x201E, 0x2026, 0x2020, 0x2021, 0x2C6,  0x2030, 0x160,
      0x2039, 0x152,  0x8D,   0x17D,  0x8F,   0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
      0x2013, 0x2014, 0x2DC,  0x2122, 0x161,  0x203A, 0x153,  0x9D,   0x17E,  0x178};
  std::string text;
  text.reserve(bytes.size());
  for (const char each : bytes) {
    const auto byte = static_cast<unsigned char>(each);
    AppendUtf8(text, byte >= 0x80 && byte < 0xA0 ? kFrom0x80.at(byte - 0x80U) : byte);
  }
  return text;
}

std::string PlainLetters(std::string_view text) {
  // From U+00C0 and from U+0430 on.
  constexpr std::string_view kLatin =
      "aaaaaaaceeeeiiiidnoooooxouuuuytsaaaaaaaceeeeiiiidnooooo/ouuuuyty"
      "aaaaaaccccccccddddeeeeeeeeeegggggggghhhhiiiiiiiiiiiijjkkkllllll-"
      "-llnnnnnnnnnoooooooorrrrrrssssssssttttttuuuuuuuuuuuuwwyyyzzzzzzs";
  constexpr std::string_view kCyrillic = "abvgdezziiklmnoprstufhccssyyyeuaeedgesiijlnckiud";
  constexpr std::string_view kSubscripts = "0123456789+-=()?aeoxehklmnpst";  // from U+2080 on
  std::string plain;
  while (!text.empty()) {
    const Utf8Character first = FirstCharacter(text);
    text.remove_prefix(first.bytes);
    const char32_t code = first.code >= 0x410 && first.code < 0x430   ? first.code + 0x20
                          : first.code >= 0x400 && first.code < 0x410 ? first.code + 0x50
                                                                      : first.code;
    if (code < 0x80) {
      const auto letter = static_cast<char>(code);
      plain += letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
    } else if (code >= 0xC0 && code < 0xC0 + kLatin.size()) {
      plain += kLatin[code - 0xC0];
    } else if (code >= 0x430 && code < 0x430 + kCyrillic.size()) {
      plain += kCyrillic[code - 0x430];
    } else if (code >= 0x218 && code < 0x21C) {
      plain += code < 0x21A ? 's' : 't';  // with a comma below
    } else if (code == 0xB5 || code == 0x3BC) {
      plain += 'u';  // micro
    } else if (code == 0xB0) {
      plain += "deg";
    } else if (code == 0x3C9 || code == 0x3A9 || code == 0x2126) {
      plain += "omega";
    } else if (code == 0x3C6 || code == 0x3B8 || code == 0x3B1) {
      plain += "phi";
    } else if (code == 0x394 || code == 0x2206) {
      plain += "delta";
    } else if (code == 0xA0 || (code >= 0x2000 && code < 0x2010)) {
      plain += ' ';
    } else if (code == 0xB7 || code == 0x22C5) {
      plain += '*';
    } else if (code == 0x2212 || code == 0x207B) {
      plain += '-';
    } else if (code == 0xB9) {
      plain += '1';
    } else if (code >= 0x2080 && code < 0x2080 + kSubscripts.size()) {
      plain += kSubscripts[code - 0x2080];
    } else if (code < 0x300 || code >= 0x370) {  // marks upon the letter before
      plain += '?';
    }
  }
  return plain;
}

}  // namespace faultlab::core
