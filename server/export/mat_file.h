#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "server/spool.h"

namespace faultlab::server {

/// Writes a MATLAB level 5 file, which `load` reads in MATLAB, Octave and scipy. Numbers are
/// double, arrays column-major, no compression. Names must be MATLAB names (letter, then letters,
/// digits, '_', at most 63). Not libmatio, because it writes to paths only and loads HDF5 at every
/// start; a test reads the result back through libmatio.
class MatFile {
 public:
  /// `about` is the text in the file's head, of which at most 116 bytes are kept. `out` must be
  /// empty and outlive this object.
  MatFile(Spool& out, std::string_view about);

  /// values [rows x columns], column after column.
  void AddMatrix(std::string_view name,
                 std::span<const double> values,
                 std::size_t rows,
                 std::size_t columns);
  void AddColumn(std::string_view name, std::span<const double> values);
  void AddScalar(std::string_view name, double value);
  /// UTF-8; code points above U+FFFF become '?', bytes that are none U+FFFD.
  void AddText(std::string_view name, std::string_view text);

  /// Reserves an array whose numbers are written later. @returns the offset of the first one in the
  /// spool
  std::uint64_t ReserveMatrix(std::string_view name, std::size_t rows, std::size_t columns);

 private:
  Spool& out_;
};

}  // namespace faultlab::server
