#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "server/spool.h"

namespace faultlab::server {

/// Writes a MATLAB level 5 file: what `load` reads in MATLAB, Octave and scipy.
/// Numbers are double, arrays column-major, no compression. Names must be MATLAB names
/// (letter, then letters, digits, '_', at most 63). Own code: libmatio writes to paths only and
/// brings HDF5 into every start; a test reads the result back through libmatio.
class MatFile {
 public:
  /// `about` is the text in the file's head, at most 116 bytes are kept. `out` is empty and
  /// outlives this.
  MatFile(Spool& out, std::string_view about);

  /// values [rows x columns], column after column.
  void AddMatrix(std::string_view name,
                 std::span<const double> values,
                 std::size_t rows,
                 std::size_t columns);
  void AddColumn(std::string_view name, std::span<const double> values);
  void AddScalar(std::string_view name, double value);
  /// UTF-8; code points above U+FFFF become '?'.
  void AddText(std::string_view name, std::string_view text);

  /// An array whose numbers come later. @returns where in the spool the first one stands.
  std::uint64_t ReserveMatrix(std::string_view name, std::size_t rows, std::size_t columns);

 private:
  Spool& out_;
};

}  // namespace faultlab::server
