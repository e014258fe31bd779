#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

/// The bytes of a file as lines of UTF-8.
struct CsvText {
  std::string_view bytes;           ///< of the file, without a byte order mark
  std::optional<std::string> made;  ///< in their place, where they had to be changed
  std::vector<std::string> notes;   ///< how they were read
  bool guessed = false;             ///< they are no UTF-8
  std::string_view text() const { return made ? std::string_view(*made) : bytes; }
};

/// Windows-1252, line ends of old Macs and JSON tables (a list of objects, or an object of lists)
/// are read. Refuses other formats by their names, with what to do.
core::Result<CsvText> ReadableText(std::string_view bytes, std::string_view name);

/// What to do with a text of another program, by its first lines; empty: it is none that is known.
std::string AdviceOnFormat(std::string_view text);

}  // namespace faultlab::server
