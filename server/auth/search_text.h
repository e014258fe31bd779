#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// Lower case of ASCII, of Latin with diacritics (U+00C0 to U+017F) and of Cyrillic (U+0400 to
/// U+042F); everything else, also what is not UTF-8, stays.
std::string FoldCase(std::string_view utf8);

/// As FoldCase, and the letters of Latin with diacritics and of Serbian Cyrillic become plain Latin
/// ones: "Ćirić" and "Ћирић" are "ciric", "Đ" is "d", "Љ" is "lj".
std::string FoldLetters(std::string_view utf8);

/// For LIKE .. ESCAPE '!': what contains `text`, whatever the case of its ASCII letters.
std::string ContainsPattern(std::string_view text);

}  // namespace faultlab::server
