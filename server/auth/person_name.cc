#include "server/auth/person_name.h"

#include <algorithm>
#include <array>

#include "core/types/utf8.h"

namespace faultlab::server {
namespace {

/// Of equal length they are in the order of their code points.
bool IsInvisible(std::string_view character) {
  struct Range {
    std::string_view first;
    std::string_view last;
  };
  constexpr std::array<Range, 8> kInvisible = {{{std::string_view("\0", 1), "\x1F"},
                                                {"\x7F", "\x7F"},
                                                {"\u0080", "\u009F"},
                                                {"\u061C", "\u061C"},    // Arabic letter mark
                                                {"\u200B", "\u200F"},    // zero width, direction
                                                {"\u2028", "\u202E"},    // separators, embeddings
                                                {"\u2060", "\u2069"},    // joiners, isolates
                                                {"\uFEFF", "\uFEFF"}}};  // byte order mark
  return std::ranges::any_of(kInvisible, [&](const Range& range) {
    return character.size() == range.first.size() && character >= range.first &&
           character <= range.last;
  });
}

}  // namespace

std::string CleanName(std::string_view utf8) {
  std::string name;
  while (!utf8.empty()) {
    const std::string_view character = utf8.substr(0, core::FirstCharacter(utf8).bytes);
    utf8.remove_prefix(character.size());
    if (character == "\t") {
      name.push_back(' ');
    } else if (!IsInvisible(character)) {
      name.append(character);
    }
  }
  name.erase(0, std::min(name.find_first_not_of(" =+-@"), name.size()));
  name.erase(name.find_last_not_of(' ') + 1);
  return name;
}

}  // namespace faultlab::server
