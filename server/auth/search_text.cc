#include "server/auth/search_text.h"

#include <algorithm>
#include <array>
#include <utility>

namespace faultlab::server {
namespace {

constexpr bool Between(unsigned code, unsigned first, unsigned last) {
  return code >= first && code <= last;
}

/// Of a character of two bytes, U+0080 to U+07FF.
unsigned LowerOf(unsigned code) {
  if (Between(code, 0xC0, 0xDE) && code != 0xD7) return code + 0x20;
  if (Between(code, 0x0400, 0x040F)) return code + 0x50;
  if (Between(code, 0x0410, 0x042F)) return code + 0x20;
  const bool odd_is_upper = Between(code, 0x0139, 0x0148) || Between(code, 0x0179, 0x017E);
  if (odd_is_upper) return code % 2 == 1 ? code + 1 : code;
  if (code == 0x0178) return 0xFF;
  if (Between(code, 0x0100, 0x0137) || Between(code, 0x014A, 0x0177)) return code | 1U;
  return code;
}

/// In the order of the code points, by pairs of a letter and its plain form.
constexpr std::array<std::pair<std::string_view, std::string_view>, 68> kPlain = {
    {{"à", "a"}, {"á", "a"}, {"â", "a"},  {"ã", "a"},  {"ä", "a"}, {"å", "a"},  {"ç", "c"},
     {"è", "e"}, {"é", "e"}, {"ê", "e"},  {"ë", "e"},  {"ì", "i"}, {"í", "i"},  {"î", "i"},
     {"ï", "i"}, {"ñ", "n"}, {"ò", "o"},  {"ó", "o"},  {"ô", "o"}, {"õ", "o"},  {"ö", "o"},
     {"ø", "o"}, {"ù", "u"}, {"ú", "u"},  {"û", "u"},  {"ü", "u"}, {"ý", "y"},  {"ÿ", "y"},
     {"ă", "a"}, {"ć", "c"}, {"č", "c"},  {"đ", "d"},  {"ě", "e"}, {"ł", "l"},  {"ń", "n"},
     {"ř", "r"}, {"š", "s"}, {"ž", "z"},  {"а", "a"},  {"б", "b"}, {"в", "v"},  {"г", "g"},
     {"д", "d"}, {"ђ", "d"}, {"е", "e"},  {"ж", "z"},  {"з", "z"}, {"и", "i"},  {"ј", "j"},
     {"к", "k"}, {"л", "l"}, {"љ", "lj"}, {"м", "m"},  {"н", "n"}, {"њ", "nj"}, {"о", "o"},
     {"п", "p"}, {"р", "r"}, {"с", "s"},  {"т", "t"},  {"ћ", "c"}, {"у", "u"},  {"ф", "f"},
     {"х", "h"}, {"ц", "c"}, {"ч", "c"},  {"џ", "dz"}, {"ш", "s"}}};

}  // namespace

std::string FoldCase(std::string_view utf8) {
  std::string out(utf8);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto byte = static_cast<unsigned char>(out[i]);
    if (byte >= 'A' && byte <= 'Z') out[i] = static_cast<char>(byte - 'A' + 'a');
    if ((byte & 0xE0U) != 0xC0U || i + 1 == out.size()) continue;
    const auto next = static_cast<unsigned char>(out[i + 1]);
    if ((next & 0xC0U) != 0x80U) continue;
    const unsigned lower = LowerOf(((byte & 0x1FU) << 6U) | (next & 0x3FU));
    out[i] = static_cast<char>(0xC0U | (lower >> 6U));
    out[i + 1] = static_cast<char>(0x80U | (lower & 0x3FU));
    ++i;
  }
  return out;
}

std::string FoldLetters(std::string_view utf8) {
  const std::string lower = FoldCase(utf8);
  std::string out;
  for (std::size_t i = 0; i < lower.size();) {
    const std::string_view two = std::string_view(lower).substr(i, 2);
    const auto found =
        std::ranges::find_if(kPlain, [&](const auto& each) { return each.first == two; });
    if (found == kPlain.end()) {
      out.push_back(lower[i++]);
    } else {
      out += found->second;
      i += 2;
    }
  }
  return out;
}

std::string ContainsPattern(std::string_view text) {
  std::string out = "%";
  for (const char c : text) {
    if (c == '%' || c == '_' || c == '!') out.push_back('!');
    out.push_back(c);
  }
  return out + "%";
}

}  // namespace faultlab::server
