#include "server/report/pdf_text.h"

#include <cairo-ft.h>
#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>

#include "core/types/utf8.h"
#include "server/plots/typeface.h"

namespace faultlab::server {
namespace {

/// The end of the character that begins at `at`.
std::size_t NextCharacter(std::string_view text, std::size_t at) {
  return at + core::FirstCharacter(text.substr(at)).bytes;
}

std::string StrongOf(std::string path) {
  const std::size_t at = path.rfind(".ttf");
  if (at == std::string::npos) return path;
  path.insert(at, "-Bold");
  return path;
}

}  // namespace

core::Result<PdfFonts> LoadPdfFonts() {
  static PdfFonts fonts;
  static FT_Library library = nullptr;
  const auto unavailable = [](const std::string& what) {
    return core::Error{core::ErrorCode::kUnavailable,
                       what +
                           "; install the package fonts-dejavu-core or set FAULTLAB_FONT to a "
                           "TrueType file",
                       "",
                       "font_missing"};
  };
  if (fonts.plain != nullptr) return fonts;
  if (library == nullptr && FT_Init_FreeType(&library) != 0) {
    return unavailable("FreeType does not start");
  }
  const std::string path = Typeface::Find();
  FT_Face plain = nullptr;
  if (path.empty() || FT_New_Face(library, path.c_str(), 0, &plain) != 0) {
    return unavailable("no font for the report");
  }
  FT_Face strong = nullptr;
  if (FT_New_Face(library, StrongOf(path).c_str(), 0, &strong) != 0) strong = plain;
  fonts.plain = cairo_ft_font_face_create_for_ft_face(plain, FT_LOAD_NO_HINTING);
  fonts.strong = cairo_ft_font_face_create_for_ft_face(strong, FT_LOAD_NO_HINTING);
  return fonts;
}

/// Valid UTF-8 without control characters: cairo stops at anything else.
std::string Clean(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const core::Utf8Character first = core::FirstCharacter(text);
    const bool control = first.code < 0x20 || (first.code >= 0x7F && first.code < 0xA0);
    if (!first.valid) {
      out += "\uFFFD";
    } else if (control) {
      out += ' ';
    } else {
      out += text.substr(0, first.bytes);
    }
    text.remove_prefix(first.bytes);
  }
  return out;
}

double TextWidth(cairo_t* cr, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  return extents.x_advance;
}

std::size_t LineEnd(cairo_t* cr, const std::string& text, std::size_t at, double width) {
  std::size_t fits = at;
  double used = 0.0;  // advances add up: cairo does not kern
  while (fits < text.size()) {
    const std::size_t end = std::min(text.find(' ', fits + 1), text.size());
    used += TextWidth(cr, text.substr(fits, end - fits));
    if (used > width) break;
    fits = end;
  }
  if (fits > at) return fits;
  std::size_t end = NextCharacter(text, at);
  used = TextWidth(cr, text.substr(at, end - at));
  while (end < text.size() && text[end] != ' ') {
    const std::size_t next = NextCharacter(text, end);
    used += TextWidth(cr, text.substr(end, next - end));
    if (used > width) break;
    end = next;
  }
  return end;
}

std::string Shortened(cairo_t* cr, const std::string& text, double width) {
  if (TextWidth(cr, text) <= width) return text;
  const std::string dots = "…";
  double used = TextWidth(cr, dots);
  std::size_t end = 0;
  while (end < text.size()) {
    const std::size_t next = NextCharacter(text, end);
    used += TextWidth(cr, text.substr(end, next - end));
    if (used > width) break;
    end = next;
  }
  return text.substr(0, end) + dots;
}

}  // namespace faultlab::server
