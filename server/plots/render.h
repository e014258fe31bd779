#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/plots/figure.h"

namespace faultlab::server {

struct RenderOptions {
  int width_px = 1600;  ///< at scale 1
  int height_px = 900;
  int scale = 1;  ///< 1 or 2: twice the pixels, same layout
  /// DejaVuSans.ttf; empty = $FAULTLAB_FONT, then where fonts-dejavu-core puts it.
  std::string font_path{};
  int png_level = 1;  ///< 1..3; above 3, encoding takes ten times as long as drawing
};

/// PNG bytes of a figure: white ground, antialiased, 1600 x 900 at scale 1.
/// kUnavailable when no font is found (the message names the package), kInvalid when scale or size
/// is out of range (width 400..4000, height 300..4000, scale 1..2).
/// Thread-safe; about 20 ms of CPU for three traces of 2000 points.
core::Result<std::string> RenderPng(const Figure& figure, const RenderOptions& options = {});

/// RGB rows, top down, without padding.
struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

inline constexpr double kPrintDpi = 300.0;

/// The same figure for paper: kPrintDpi, lines and text a little larger than in the PNG. kInvalid
/// when the size is out of range (80..300 mm, 50..300 mm).
core::Result<Pixels> RenderForPrint(const Figure& figure,
                                    double width_mm,
                                    double height_mm,
                                    const std::string& font_path = {});

}  // namespace faultlab::server
