#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace faultlab::server {

/// PNG of 8-bit RGB pixels, rows top down without padding; rgb.size() == 3 * width * height.
/// Rows are filtered by "up", which suits drawings, because most rows repeat the one above. zlib
/// runs at `level` 1..9 with run-length matching only; on a plot this is five times faster than a
/// general encoder at equal size. A word processor derives the size of the picture from
/// `pixels_per_metre`. Not OpenCV's imgcodecs, because it loads 120 shared libraries at every
/// start.
std::string EncodePng(std::span<const std::uint8_t> rgb,
                      int width,
                      int height,
                      int level,
                      std::uint32_t pixels_per_metre);

}  // namespace faultlab::server
