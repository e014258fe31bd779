#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace faultlab::server {

/// Where the names of the columns are.
struct HeaderLine {
  std::uint32_t number = 0;  ///< counted from 1; 0: no line above the numbers names a time
  char separator = ',';
  bool whole = false;  ///< it names a whole recording
};

/// The last line above the numbers that names a whole recording (time, command and measurement),
/// else the first that names a time: titles, an operator's name or a row of long names may stand
/// above it. It may be a comment, as NumPy writes it ("# t,uc,um"), and "sep=;" above it says what
/// separates the cells.
HeaderLine FindHeaderLine(std::string_view text);

/// For the end of a message about a header without a needed name; may be empty.
std::string_view AdviceOnNames(std::string_view header);

}  // namespace faultlab::server
