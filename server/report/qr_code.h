#pragma once

#include <optional>
#include <string>
#include <vector>

namespace faultlab::server {

/// The squares of a QR code, without the quiet border.
struct QrCode {
  int width = 0;           ///< squares in a row, as many rows
  std::vector<bool> dark;  ///< [width x width], row by row
};

/// Error correction M (15 % of the squares may be unreadable). Nothing for a text that fits in no
/// code (2331 bytes).
std::optional<QrCode> MakeQrCode(const std::string& text);

}  // namespace faultlab::server
