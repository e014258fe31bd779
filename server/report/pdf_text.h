#pragma once

#include <cairo.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "core/types/result.h"

namespace faultlab::server {

/// The fonts of a document. They exist until the process ends: cairo keeps what it has measured of
/// them.
struct PdfFonts {
  cairo_font_face_t* plain = nullptr;
  cairo_font_face_t* strong = nullptr;
};

/// Loaded once; one thread at a time. Unavailable when there is no font.
core::Result<PdfFonts> LoadPdfFonts();

/// Valid UTF-8 without control characters: cairo stops at anything else.
std::string Clean(std::string_view text);

// Of clean texts in the font that `cr` has now; widths in points.

double TextWidth(cairo_t* cr, const std::string& text);

/// Where the line that begins at `at` ends: behind its last whole word; inside a word only when it
/// fills the line alone.
std::size_t LineEnd(cairo_t* cr, const std::string& text, std::size_t at, double width);

/// The text, or as much of it as fits, and "…".
std::string Shortened(cairo_t* cr, const std::string& text, double width);

}  // namespace faultlab::server
