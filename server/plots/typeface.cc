#include "server/plots/typeface.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>

#include "core/types/utf8.h"

namespace faultlab::server {
namespace {

constexpr std::array<const char*, 5> kUsualPlaces = {
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
    "/usr/share/fonts/TTF/DejaVuSans.ttf",
    "/usr/local/share/fonts/DejaVuSans.ttf"};
constexpr double kScriptSize = 0.72;
constexpr double kSubscriptDrop = 0.20;
constexpr double kSuperscriptRise = 0.36;
constexpr double kAscent = 0.95;   // of the size: room for Å and for a superscript
constexpr double kDescent = 0.35;  // room for g and for a subscript
constexpr int kFixedPoint = 64;    // FreeType counts in 1/64 pixel

/// A part of a text at one height.
struct Piece {
  std::string_view text;
  int shift = 0;  // -1 subscript, 0, +1 superscript
};

std::vector<Piece> SplitScripts(std::string_view text) {
  std::vector<Piece> pieces;
  while (!text.empty()) {
    const std::size_t down = text.find("_{");
    const std::size_t up = text.find("^{");
    const std::size_t start = std::min(down, up);
    const std::size_t end = start == std::string_view::npos ? start : text.find('}', start);
    if (end == std::string_view::npos) {
      pieces.push_back({text, 0});
      break;
    }
    if (start > 0) {
      pieces.push_back({text.substr(0, start), 0});
    }
    pieces.push_back({text.substr(start + 2, end - start - 2), start == down ? -1 : 1});
    text.remove_prefix(end + 1);
  }
  return pieces;
}

struct Glyph {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
  long advance = 0;  // 1/64 pixel
  std::vector<std::uint8_t> coverage;
};

class FreeTypeFace final : public Typeface {
 public:
  FreeTypeFace(FT_Library library, FT_Face face) : library_(library), face_(face) {}
  FreeTypeFace(const FreeTypeFace&) = delete;
  FreeTypeFace& operator=(const FreeTypeFace&) = delete;
  ~FreeTypeFace() override {
    FT_Done_Face(face_);
    FT_Done_FreeType(library_);
  }

  int Width(std::string_view text, int size_px) override {
    return Walk(text, size_px, [](const Glyph&, int, int) {});
  }

  TextBitmap Draw(std::string_view text, int size_px) override {
    TextBitmap bitmap;
    const int margin = 2;  // a slanted or wide letter may be wider than its advance
    bitmap.width = Width(text, size_px) + margin;
    bitmap.baseline = static_cast<int>(std::ceil(kAscent * size_px));
    bitmap.height = bitmap.baseline + static_cast<int>(std::ceil(kDescent * size_px));
    bitmap.coverage.assign(
        static_cast<std::size_t>(bitmap.width) * static_cast<std::size_t>(bitmap.height), 0);
    Walk(text, size_px, [&](const Glyph& glyph, int x, int rise) {
      Copy(glyph, x + glyph.left, bitmap.baseline - rise - glyph.top, bitmap);
    });
    return bitmap;
  }

 private:
  /// Calls `place(glyph, pen x, rise)` for each letter; returns the width in pixels.
  template <typename Place>
  int Walk(std::string_view text, int size_px, Place place) {
    long pen = 0;
    for (const Piece& piece : SplitScripts(text)) {
      const int size =
          piece.shift == 0 ? size_px : static_cast<int>(std::lround(kScriptSize * size_px));
      const double rise = piece.shift < 0   ? -kSubscriptDrop * size_px
                          : piece.shift > 0 ? kSuperscriptRise * size_px
                                            : 0.0;
      std::string_view rest = piece.text;
      while (!rest.empty()) {
        const core::Utf8Character first = core::FirstCharacter(rest);
        rest.remove_prefix(first.bytes);
        const Glyph& glyph = Load(first.code, size);
        place(glyph,
              static_cast<int>((pen + kFixedPoint / 2) / kFixedPoint),
              static_cast<int>(std::lround(rise)));
        pen += glyph.advance;
      }
    }
    return static_cast<int>((pen + kFixedPoint - 1) / kFixedPoint);
  }

  const Glyph& Load(char32_t code, int size_px) {
    Glyph& glyph = glyphs_[{code, size_px}];
    if (glyph.advance != 0) {
      return glyph;
    }
    FT_Set_Pixel_Sizes(face_, 0, static_cast<FT_UInt>(size_px));
    if (FT_Load_Char(face_, code, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0) {
      glyph.advance = static_cast<long>(size_px) * kFixedPoint / 2;
      return glyph;
    }
    const FT_GlyphSlot slot = face_->glyph;
    glyph.left = slot->bitmap_left;
    glyph.top = slot->bitmap_top;
    glyph.width = static_cast<int>(slot->bitmap.width);
    glyph.height = static_cast<int>(slot->bitmap.rows);
    glyph.advance = std::max(1L, slot->advance.x);
    for (int row = 0; row < glyph.height; ++row) {
      const std::uint8_t* line = slot->bitmap.buffer + row * slot->bitmap.pitch;
      glyph.coverage.insert(glyph.coverage.end(), line, line + glyph.width);
    }
    return glyph;
  }

  static void Copy(const Glyph& glyph, int left, int top, TextBitmap& to) {
    for (int row = 0; row < glyph.height; ++row) {
      const int y = top + row;
      if (y < 0 || y >= to.height) {
        continue;
      }
      for (int column = 0; column < glyph.width; ++column) {
        const int x = left + column;
        if (x < 0 || x >= to.width) {
          continue;
        }
        std::uint8_t& cell = to.coverage[static_cast<std::size_t>(y * to.width + x)];
        cell = std::max(cell, glyph.coverage[static_cast<std::size_t>(row * glyph.width + column)]);
      }
    }
  }

  FT_Library library_;
  FT_Face face_;
  std::map<std::pair<char32_t, int>, Glyph> glyphs_;
};

}  // namespace

std::string Typeface::Find(const std::string& wanted) {
  if (!wanted.empty()) {
    return wanted;
  }
  if (const char* from_environment = std::getenv("FAULTLAB_FONT")) {
    return from_environment;
  }
  const auto readable = [](const char* path) { return ::access(path, R_OK) == 0; };
  const auto found = std::ranges::find_if(kUsualPlaces, readable);
  return found == kUsualPlaces.end() ? "" : *found;
}

core::Result<std::unique_ptr<Typeface>> Typeface::Load(const std::string& wanted) {
  const std::string path = Find(wanted);
  const auto unavailable = [](const std::string& what) {
    return core::Error{core::ErrorCode::kUnavailable,
                       what +
                           "; install the package fonts-dejavu-core or set FAULTLAB_FONT to a "
                           "TrueType file",
                       "",
                       "font_missing"};
  };
  if (path.empty()) {
    return unavailable("no font for pictures: DejaVuSans.ttf is in none of its usual places");
  }
  FT_Library library = nullptr;
  if (FT_Init_FreeType(&library) != 0) {
    return unavailable("FreeType does not start");
  }
  FT_Face face = nullptr;
  if (FT_New_Face(library, path.c_str(), 0, &face) != 0) {
    FT_Done_FreeType(library);
    return unavailable("no font for pictures: cannot read " + path);
  }
  return std::unique_ptr<Typeface>(std::make_unique<FreeTypeFace>(library, face));
}

}  // namespace faultlab::server
