#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace faultlab::core {

/// One character of a text in UTF-8 (RFC 3629).
struct Utf8Character {
  char32_t code = 0;      ///< U+FFFD where there is none
  std::size_t bytes = 1;  ///< 1 to 4
  bool valid = true;
};

/// The first one of a text that is not empty. A byte that begins no character (a cut or overlong
/// one, half of a pair of UTF-16) counts alone.
Utf8Character FirstCharacter(std::string_view text);

bool IsUtf8(std::string_view text);

/// As much of a valid text as fits into `bytes_max` bytes, without a part of a character.
std::string_view CutUtf8(std::string_view text, std::size_t bytes_max);

/// The character as UTF-8; U+FFFD for what is none.
void AppendUtf8(std::string& text, char32_t code);

/// Text of Windows-1252, as older programs write it, in UTF-8.
std::string FromWindows1252(std::string_view bytes);

/// To compare words of several languages: small letters of ASCII, without accents; Cyrillic as
/// Serbian transliterates it. What has no such letter is a question mark.
std::string PlainLetters(std::string_view text);

}  // namespace faultlab::core
